"""How each cell ends: whole, separated from a neighbour, or burst, whichever comes first along the load path.

Two numbers of a cell grow to 1, and each load factor at which one first does is interpolated linearly between accepted
steps with released walls:

- utilisation: of its wall, see `ngcell.results.rupture.strength`; at 1 the wall ruptures, and the cell has burst;
- parting: the largest of all pairs of walls that it shares. Of a pair with bonds it is the share of bonds that are
  broken, opened beyond the opening at full strength, over one half; of a pair without, its mean gap over the mark at
  which gaps count as growing, see `ngcell.results.growth`. At 1 the cell has separated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import broken_share, stored_in_bodies
from ngcell.results.growth import ONSET
from ngcell.results.walls import pair_gaps

Array = NDArray[np.float64]

#: How a cell ends.
ENDS = WHOLE, SEPARATED, BURST = ("whole", "separated", "burst")
#: Share of broken bonds at which a pair of walls has separated.
HALF = 0.5


@dataclass(frozen=True, eq=False)
class CellEnds:
    """How cells have ended so far.

    Attributes
    ----------
    at : float
        Load factor of the last step.
    progress : array of float, shape (2, bodies)
        Utilisation and parting there [1].
    loads : array of float, shape (2, bodies)
        Load factors at which each first reached 1; NaN where it has not.
    energy : array of float, shape (bodies,)
        What each body stores there [energy].
    burst_energy : array of float, shape (bodies,)
        What it stored where its wall ruptured [energy]; 0 where it has not.
    """

    at: float
    progress: Array
    loads: Array
    energy: Array
    burst_energy: Array

    @classmethod
    def starting(cls, at: float, progress: Array, energy: Array) -> CellEnds:
        """Return where the load path starts."""
        is_there = progress >= 1
        return cls(at, progress, np.where(is_there, at, np.nan), energy, np.where(is_there[0], energy, 0.0))

    def after(self, at: float, progress: Array, energy: Array) -> CellEnds:
        """Return how cells have ended after one more step."""
        reached = np.isnan(self.loads) & (progress >= 1)
        before = np.minimum(self.progress, 1)
        share = (1 - before) / np.maximum(progress - before, np.finfo(float).tiny)
        share = np.clip(np.nan_to_num(share, nan=1.0), 0, 1)
        loads = np.where(reached, self.at + share * (at - self.at), self.loads)
        there = self.energy + share[0] * (energy - self.energy)
        return CellEnds(at, progress, loads, energy, np.where(reached[0], there, self.burst_energy))

    @property
    def ends(self) -> list[str]:
        """How each cell has ended: one of `ENDS`."""
        return [end_of(*loads) for loads in self.loads.T.tolist()]

    def columns(self, body: int) -> dict[str, float]:
        """Return the further columns of a cell's row."""
        burst_at, separated_at = self.loads[:, body].tolist()
        return {
            "utilisation": float(self.progress[0, body]),
            "burst_at": burst_at,
            "separated_at": separated_at,
            "burst_energy": float(self.burst_energy[body]),
        }

    def array(self) -> Array:
        """Return all of it as one array, shape (7, bodies)."""
        at = np.full(len(self.energy), self.at)
        return np.array([*self.progress, *self.loads, self.energy, self.burst_energy, at])

    @classmethod
    def from_array(cls, rows: Array) -> CellEnds:
        """Return what `array` was made from."""
        return cls(float(rows[6, 0]), rows[:2], rows[2:4], rows[4], rows[5])


def end_of(burst_at: float, separated_at: float) -> str:
    """Return how a cell ends whose wall ruptures, and which separates, at these load factors; NaN for never."""
    if np.isnan(burst_at) and np.isnan(separated_at):
        return WHOLE
    return BURST if np.isnan(separated_at) or burst_at < separated_at else SEPARATED


def parting(facing: FacingWalls, gap: Array, problem: Problem, at: Configuration) -> Array:
    """Return how far each cell has come to separating from a neighbour, shape (bodies,) [1]; 1 where it has."""
    pairs = facing.pairs
    share = np.maximum(pair_gaps(facing, gap) / (ONSET * facing.thickness), 0.0) if len(pairs) else np.zeros(0)
    broken = broken_share(problem.terms, at, pairs)
    share = np.where(np.isnan(broken), share, broken / HALF)
    largest = np.zeros(problem.space.body_count)
    np.maximum.at(largest, pairs, share[:, None])
    return largest


def followed(
    before: CellEnds | None, load: float, utilisation: Array, parted: Array, problem: Problem, at: Configuration
) -> CellEnds:
    """Return how cells have ended after a step; `before` is None where no state before it is known."""
    progress, energy = np.array([utilisation, parted]), stored_in_bodies(problem.terms, at, problem.space.body_count)
    return CellEnds.starting(load, progress, energy) if before is None else before.after(load, progress, energy)


def at_rest(bodies: int) -> CellEnds:
    """Return how cells start that are in equilibrium at rest: without stress, and none separated."""
    return CellEnds.starting(0.0, np.zeros((2, bodies)), np.zeros(bodies))
