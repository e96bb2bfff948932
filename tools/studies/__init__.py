"""What results depend on, and what they cost.

Tables are kept in `tools/results`, pictures in `docs`; runs whose rows are there are not repeated.
"""

from __future__ import annotations

from tools.commands import Commands

commands = Commands(
    "tools.studies",
    ("accuracy", "agreement", "averaged", "cohesion", "cohesion-curves", "constants", "contact-kinds", "cost",
     "ensemble-curves", "equal-error", "figures", "growing", "irregular", "kinds", "last-digits", "members", "phases",
     "plain-newton", "promised", "rupture-map", "scaling", "settings", "sweeps", "versions", "whole-command",
     "work-precision"),
    __doc__,
)  # fmt: skip
