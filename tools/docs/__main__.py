"""``python -m tools.docs``."""

from tools.docs.build import command

command()
