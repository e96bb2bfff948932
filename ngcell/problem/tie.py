"""The tied solid: coincident walls tied exactly, by identifying their unknowns.

Two wall edges that coincide have the same polynomials; in NGSolve's hierarchical basis an unknown of one edge is then
plus or minus one unknown of the other (the sign of an odd bubble turns with the orientation of the edge). The
relation is read off the sampled shape functions, so it holds for every order, and chains of identifications
(three cells at a corner) are closed as connected components. No penalty term, no multiplier, no parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.walls import Walls
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
    middle = walls.basis.values(walls.basis.centre[None])[0] @ walls.rest
    length = np.linalg.norm(walls.rest[:, -1] - walls.rest[:, 0], axis=1)
    one, two = near_pairs(middle, COINCIDENCE * length.min())
    _, apart = _matched(walls, one, two)
    same = (walls.body[one] != walls.body[two]) & (apart < COINCIDENCE * length[one])
    return np.column_stack([one[same], two[same]])


def _matched(walls: Walls, one: Index, two: Index) -> tuple[Index, Array]:
    """Return the node of `two` at each node of `one`, (pairs, nodes), and the largest distance of such nodes."""
    if walls.dimension == 2:
        nodes = np.tile(np.arange(walls.basis.order, -1, -1), (len(one), 1))
    else:
        nodes = np.linalg.norm(walls.rest[one][:, :, None] - walls.rest[two][:, None], axis=3).argmin(2)
    there = np.take_along_axis(walls.rest[two], nodes[:, :, None], axis=1)
    return nodes, np.linalg.norm(walls.rest[one] - there, axis=2).max(1)


def tie_walls(walls: Walls, size: int) -> Tie:
    """Tie all coincident edges; `size` is the number of scalar unknowns."""
    one, two = coincident_edges(walls).T
    # Nodal values run in opposite directions along the two edges: nodal[one] u = reverse(nodal[two] u').
    nodes, _ = _matched(walls, one, two)
    relation = np.linalg.solve(np.take_along_axis(walls.nodal[two], nodes[:, :, None], axis=1), walls.nodal[one])
    pair, mine, theirs = np.nonzero(np.abs(relation.transpose(0, 2, 1)) > 0.5)
    row, column = walls.dofs[one][pair, mine], walls.dofs[two][pair, theirs]
    sign = np.sign(relation[pair, theirs, mine])
    component = components(size, row, column)
    master = np.full(component.max() + 1, size)
    np.minimum.at(master, component, np.arange(size))
    master = master[component]
    # Each unknown stands twice, for +u and for -u; whichever of them is connected with its master tells the sign.
    opposite = np.where(sign > 0, 0, size)
    links = np.concatenate([row, row + size]), np.concatenate([column + opposite, column + (size - opposite)])
    signed = components(2 * size, *links)
    return Tie(master, np.where(signed[:size] == signed[master], 1.0, -1.0))
