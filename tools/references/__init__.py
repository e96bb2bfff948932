"""Answers that come from a second way, or exactly, and what is computed beside them.

A command prints what it found; `certify` and `peel` keep tables in `tools/results`, `hertz` draws `docs/hertz.png`.
"""

from __future__ import annotations

from tools.commands import Commands

commands = Commands(
    "tools.references",
    ("averages", "certify", "confined", "contact-error", "expected", "hertz", "manufactured", "moduli", "peel", "peers",
     "prisms", "radial", "spheres"),
    __doc__,
)
