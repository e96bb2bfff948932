"""``python -m tools.references``."""

from tools.references import commands

commands()
