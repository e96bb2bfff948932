"""Gap and contact pressure along the walls, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.assembly import Assembly, State
from ngcell.contact.facing import FacingWalls
from ngcell.contact.search import nearest_on_body
from ngcell.contact.walls import WallPoints, Walls

Array = NDArray[np.float64]

_PLACES = np.array([0.0, 0.5, 1.0])


def wall_fields(walls: Walls, facing: FacingWalls, assembly: Assembly, state: State) -> tuple[Array, Array]:
    """Return gap [length] and contact pressure [stress] at ``xi = 0, 1/2, 1`` of each wall edge, both (edges, 3).

    The gap is the one to the body that the wall faced at rest, NaN where it faced none. The pressure, >= 0, is the
    true one, for each deformed length, whichever body presses.
    """
    positions = assembly.positions(assembly.expand(state.displacement))
    nodes = walls.nodes(positions)
    gap = np.full((walls.edge_count, len(_PLACES)), np.nan)
    edge, first = np.unique(facing.edge, return_index=True)
    points = walls.basis.values(_PLACES) @ nodes[edge]
    body = np.repeat(facing.other[first], len(_PLACES))
    gap[edge] = nearest_on_body(walls, nodes, points.reshape(-1, 2), body).reshape(-1, len(_PLACES))
    if assembly.contact is None:
        return gap, np.zeros_like(gap)
    everywhere = WallPoints(
        np.repeat(np.arange(walls.edge_count), len(_PLACES)), np.tile(_PLACES, walls.edge_count), np.zeros(gap.size)
    )
    nominal = assembly.contact.pressures(positions, everywhere).reshape(gap.shape)
    return gap, nominal * _speed(walls, walls.rest) / _speed(walls, nodes)


def _speed(walls: Walls, nodes: Array) -> Array:
    """Return the length of the tangent at the places, shape (edges, 3)."""
    return np.asarray(np.linalg.norm(np.einsum("ki,eid->ekd", walls.basis.values(_PLACES, 1), nodes), axis=2))
