"""Where iterations of a minimisation lead nowhere."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf


@dataclass
class Progress:
    """The last iterations of a minimisation.

    Attributes
    ----------
    idle : int
        Iterations without progress that tell.
    """

    idle: int
    _lowest: float = inf
    _rested: int = 0
    _totals: list[float] = field(default_factory=list)

    def note(self, decrement: float, total: float, was_held: bool) -> None:
        """Take down an iteration: its decrement [energy], the energy that it started from, whether a step was refused,
        or damped."""
        self._totals = [*self._totals[1 - self.idle :], total] if was_held else []
        if decrement < self._lowest / 4:
            self._lowest, self._rested = decrement, 0
        elif decrement <= 4 * self._lowest:
            self._rested += 1

    def rests_below(self, decrement: float) -> bool:
        """Return whether decrements have come to their lowest, below this one, and fall no more [energy]."""
        return self._rested == self.idle and self._lowest <= decrement

    def creeps(self, total: float, tolerance: float) -> bool:
        """Return whether as many iterations as tell had steps refused or damped, and gained less than `tolerance`
        [energy] together: at a kink, where the model of the energy says nothing of the other side."""
        return len(self._totals) == self.idle and self._totals[0] - total < tolerance
