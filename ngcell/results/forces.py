"""Forces between bodies and on supports.

A force between bodies is that of all terms that act between them. It is reported as the one on the body with the lower
number; the other body feels its opposite.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.term import Interaction
from ngcell.problem.problem import Problem
from ngcell.problem.reports import interaction
from ngcell.problem.state import State

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Resultant forces between bodies.

    Attributes
    ----------
    bodies : array of int, shape (pairs, 2)
        Bodies in touch or joined by bonds, the lower number first.
    force : array of float, shape (pairs, dimension)
        Force on the first body of each pair [stress * length].
    on_body : array of float, shape (bodies, dimension)
        Sum of these forces on each body.
    pressed : array of float, shape (bodies,)
        Sum of the magnitudes of the forces between each body and others.
    normal : array of float, shape (pairs,)
        Sum of the magnitudes of the normal contact forces of each pair [stress * length], >= 0.
    """

    bodies: NDArray[np.int64]
    force: Array
    on_body: Array
    pressed: Array
    normal: Array

    @property
    def total(self) -> float:
        """Sum of the magnitudes over all pairs [stress * length]."""
        return float(np.linalg.norm(self.force, axis=1).sum())

    def between(self, pairs: NDArray[np.int64]) -> Array:
        """Return the magnitude of the force between the bodies of each pair, shape (pairs,)."""
        return self._of(pairs, np.linalg.norm(self.force, axis=1))

    def normal_between(self, pairs: NDArray[np.int64]) -> Array:
        """Return the sum of the magnitudes of the normal contact forces between the bodies of each pair, (pairs,)."""
        return self._of(pairs, self.normal)

    def from_bodies(self, chosen: NDArray[np.bool_]) -> Array:
        """Return the sum of the magnitudes of the forces between each body and chosen others, shape (bodies,)."""
        size, (one, two) = np.linalg.norm(self.force, axis=1), self.bodies.T
        found = np.zeros(len(chosen))
        np.add.at(found, one, np.where(chosen[two], size, 0.0))
        np.add.at(found, two, np.where(chosen[one], size, 0.0))
        return found

    def _of(self, pairs: NDArray[np.int64], sizes: Array) -> Array:
        known = {(int(one), int(two)): float(size) for (one, two), size in zip(self.bodies, sizes, strict=True)}
        return np.array([known.get((int(one), int(two)), 0.0) for one, two in pairs])


def contact_forces(problem: Problem, state: State) -> ContactForces:
    """Return the forces between bodies in a state."""
    return _resultants(interaction(problem.terms, state.at), problem.space.body_count)


def _resultants(acting: Interaction, count: int) -> ContactForces:
    mine, theirs = acting.bodies.T
    on_lower = np.where((mine < theirs)[:, None], acting.force, -acting.force)
    found, place = np.unique(np.minimum(mine, theirs) * count + np.maximum(mine, theirs), return_inverse=True)
    dimension = acting.force.shape[1]
    sums = np.zeros((len(found), dimension))
    np.add.at(sums, place.ravel(), on_lower)
    bodies = np.column_stack(np.divmod(found, count))
    on_body, pressed = np.zeros((count, dimension)), np.zeros(count)
    size = np.linalg.norm(sums, axis=1)
    for column, sign in enumerate((1, -1)):
        np.add.at(on_body, bodies[:, column], sign * sums)
        np.add.at(pressed, bodies[:, column], size)
    normal = np.zeros(len(found))
    np.add.at(normal, place.ravel(), acting.normal)
    return ContactForces(bodies, sums, on_body, pressed, normal)
