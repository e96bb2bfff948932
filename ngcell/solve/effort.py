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


class OutOfIterations(Exception):  # noqa: N818 - named as what is reported, not as a mistake
    """A step has taken all the iterations that it was given."""


@dataclass
class Budget:
    """The iterations of a step, all minimisers together, and all attempts."""

    most: float = float("inf")
    spent: int = 0

    def renew(self) -> None:
        """Begin with the next step."""
        self.spent = 0

    def spend(self) -> None:
        """Take one; raise `OutOfIterations` if there is none left."""
        if self.spent >= self.most:
            raise OutOfIterations
        self.spent += 1
