"""``python -m tools.extreme``."""

from tools.extreme import commands

commands()
