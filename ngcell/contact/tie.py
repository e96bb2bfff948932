"""The compact solid: coincident walls tied exactly, by identifying their unknowns.

Two wall edges that coincide carry the same polynomials; in NGSolve's hierarchical basis an unknown of one edge is then
plus or minus one unknown of the other (the sign of an odd bubble turns with the orientation of the edge). The
relation is read off the sampled shape functions, so it holds for every order, and chains of identifications
(three cells at a corner) are closed as connected components. No spring, no multiplier, no parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.walls import Walls
from ngcell.geometry.near import components, near_pairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distance, in edge lengths, below which two nodes coincide.
COINCIDENCE = 1e-6


@dataclass(frozen=True, eq=False)
class Tie:
    """Identification of scalar unknowns: ``u = sign * u[master]``.

    Attributes
    ----------
    master : array of int, shape (scalar unknowns,)
        Unknown that stands for each unknown; a master stands for itself.
    sign : array of float, shape (scalar unknowns,)
        +1 or -1.
    """

    master: Index
    sign: Array

    @property
    def is_trivial(self) -> bool:
        """Whether nothing is tied."""
        return bool((self.master == np.arange(len(self.master))).all())


def coincident_edges(walls: Walls) -> Index:
    """Return the pairs of edges of different bodies that coincide in the reference state, shape (pairs, 2)."""
    middle = walls.basis.values(np.array([0.5]))[0] @ walls.rest
    length = np.linalg.norm(walls.rest[:, -1] - walls.rest[:, 0], axis=1)
    one, two = near_pairs(middle, COINCIDENCE * length.min())
    apart = np.linalg.norm(walls.rest[one] - walls.rest[two][:, ::-1], axis=2).max(1)
    same = (walls.body[one] != walls.body[two]) & (apart < COINCIDENCE * length[one])
    return np.column_stack([one[same], two[same]])


def tie_walls(walls: Walls, size: int) -> Tie:
    """Tie all coincident edges; `size` is the number of scalar unknowns."""
    one, two = coincident_edges(walls).T
    # Nodal values run in opposite directions along the two edges: nodal[one] u = reverse(nodal[two] u').
    relation = np.linalg.solve(walls.nodal[two][:, ::-1], walls.nodal[one])
    pair, mine, theirs = np.nonzero(np.abs(relation.transpose(0, 2, 1)) > 0.5)
    row, column = walls.dofs[one][pair, mine], walls.dofs[two][pair, theirs]
    sign = np.sign(relation[pair, theirs, mine])
    # Signs only occur on bubbles, which belong to one edge each: their chains have length one.
    component = components(size, row, column)
    master = np.full(component.max() + 1, size)
    np.minimum.at(master, component, np.arange(size))
    master = master[component]
    signs = np.ones(size)
    signs[np.where(master[column] == column, row, column)] = sign
    signs[master == np.arange(size)] = 1
    return Tie(master, signs)
