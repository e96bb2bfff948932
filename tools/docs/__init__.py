"""What is handed to others: the documentation as a site, its notebooks, and releases that install anywhere."""

from __future__ import annotations

from tools.commands import Commands

commands = Commands("tools.docs", ("site", "notebooks", "release"), __doc__)
