"""``python -m tools.docs``."""

from tools.docs import commands

commands()
