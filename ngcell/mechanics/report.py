"""What terms report to the certificate: checks, each with its limit and its meaning, and the scales they are taken in.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One line of the certificate.

    Attributes
    ----------
    name : str
        What is judged.
    value : float
        What was measured, without unit.
    limit : float
        The largest value that passes; with `must_exceed` the value has to be larger.
    meaning : str
        What the number is, in words.
    must_exceed : bool
        Whether the limit is a lower one.
    place : str
        Where it was measured; empty where that says nothing.
    """

    name: str
    value: float
    limit: float
    meaning: str
    must_exceed: bool = False
    place: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value keeps the limit; NaN never does."""
        return self.value > self.limit if self.must_exceed else self.value <= self.limit

    def is_worse_than(self, other: Check) -> bool:
        """Whether the value is farther on the wrong side than that of another check of the same name."""
        if self.value != self.value:
            return True
        return self.value < other.value if self.must_exceed else self.value > other.value


#: Share of what counts as hardly strained below which walls are not strained: as solvers have it.
_OF_HARDLY = 0.1


@dataclass(frozen=True)
class Scales:
    """What counts as nothing, and what checks are taken in shares of.

    Attributes
    ----------
    force, energy : float
        Force and energy of a wall that is hardly strained.
    thickness : float
        Smallest thickness of a body [length].
    stored : float
        Stored energy of the step.
    """

    force: float
    energy: float
    thickness: float
    stored: float

    @property
    def force_of_nothing(self) -> float:
        """Below it forces hold nothing where nothing is stored: that of a wall strained by a tenth of hardly."""
        return _OF_HARDLY * self.force

    @property
    def is_unstrained(self) -> bool:
        """Whether walls are strained by less than a tenth of hardly, as where they have slid out."""
        return abs(self.stored) <= _OF_HARDLY**2 * self.energy

    @property
    def at_stake(self) -> float:
        """The stored energy, or that of a wall that is hardly strained where less is stored."""
        return max(self.stored, self.energy)
