"""What happens far outside comfort: a map of small scenes, each run in a process of its own, and what came of it."""

from __future__ import annotations

from tools.commands import Commands

commands = Commands("tools.extreme", ("hostile", "hostile-python", "list", "map", "one", "soak"), __doc__)
