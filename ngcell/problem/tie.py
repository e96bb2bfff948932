"""The tied solid: coincident walls tied exactly, by identifying their unknowns.

Two facets that coincide have the same polynomials; in NGSolve's hierarchical basis an unknown of one facet is then
plus or minus one unknown of the other (the sign of an odd bubble changes with the orientation of the facet). The
relation is read off the sampled shape functions, so it holds for every order, and chains of identifications
(three cells at a corner) are closed as connected components. No penalty term, no multiplier, no parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.surface import Surface
from ngcell.geometry.near import components, near_pairs
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distance, in sizes of facets, below which two nodes coincide.
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


def coincident_facets(walls: Surface) -> Index:
    """Return the pairs of facets of different bodies that coincide in the reference state, shape (pairs, 2)."""
    if not walls.facet_count:
        return np.zeros((0, 2), dtype=np.int64)
    one, two = near_pairs(walls.centres(walls.rest), COINCIDENCE * walls.sizes.min())
    _, apart = _matched(walls, one, two)
    same = (walls.body[one] != walls.body[two]) & (apart < COINCIDENCE * walls.sizes[one])
    return np.column_stack([one[same], two[same]])


def _matched(walls: Surface, one: Index, two: Index) -> tuple[Index, Array]:
    """Return the node of `two` nearest to each node of `one`, (pairs, nodes), and the largest distance of those."""
    away = np.linalg.norm(walls.rest[one][:, :, None] - walls.rest[two][:, None], axis=3)
    return away.argmin(2), away.min(2).max(1)


def tie_walls(walls: Surface, size: int) -> Tie:
    """Tie all coincident facets; `size` is the number of scalar unknowns."""
    one, two = coincident_facets(walls).T
    # Facets of two bodies are oriented differently; nodal values are the same: nodal[one] u = nodal[two][nodes] u'.
    nodes, _ = _matched(walls, one, two)
    relation = np.linalg.solve(np.take_along_axis(walls.nodal[two], nodes[:, :, None], axis=1), walls.nodal[one])
    pair, mine, theirs = np.nonzero(np.abs(relation.transpose(0, 2, 1)) > 0.5)
    row, column = walls.dofs[one][pair, mine], walls.dofs[two][pair, theirs]
    sign = np.sign(relation[pair, theirs, mine])
    component = components(size, row, column)
    master = np.full(component.max() + 1, size)
    np.minimum.at(master, component, np.arange(size))
    master = master[component]
    # Each unknown occurs twice, for +u and for -u; whichever of them is connected with its master tells the sign.
    opposite = np.where(sign > 0, 0, size)
    links = np.concatenate([row, row + size]), np.concatenate([column + opposite, column + (size - opposite)])
    signed = components(2 * size, *links)
    return Tie(master, np.where(signed[:size] == signed[master], 1.0, -1.0))


def solid_of_body(space: DisplacementSpace, tie: Tie | None) -> Index:
    """Return the solid that each body is part of, shape (bodies,): bodies that are tied to each other are one."""
    body = space.body_of_unknown
    return components(space.body_count, body, body if tie is None else body[tie.master])
