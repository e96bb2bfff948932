"""What a minimisation costs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Effort:
    """What was spent."""

    iterations: int = 0
    factorisations: int = 0
    evaluations: int = 0
    refusals: int = 0
    patterns: int = 0
    cutbacks: int = 0

    def __sub__(self, other: Effort) -> Effort:
        return Effort(**{name: getattr(self, name) - getattr(other, name) for name in vars(self)})

    def __add__(self, other: Effort) -> Effort:
        return Effort(**{name: getattr(self, name) + getattr(other, name) for name in vars(self)})

    def copy(self) -> Effort:
        """Return a copy that no longer changes."""
        return Effort(**vars(self))
