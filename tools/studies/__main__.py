"""``python -m tools.studies``."""

from tools.studies import commands

commands()
