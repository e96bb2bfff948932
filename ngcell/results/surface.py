"""Gap and contact pressure along the walls, for pictures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.assembly import Assembly, State
from ngcell.contact.facing import FacingWalls
from ngcell.contact.penalty import PenaltyContact
from ngcell.contact.search import nearest_on_body
from ngcell.contact.walls import Walls

Array = NDArray[np.float64]

_PLACES = np.array([0.0, 0.5, 1.0])


def wall_fields(walls: Walls, facing: FacingWalls, assembly: Assembly, state: State) -> tuple[Array, Array]:
    """Return gap [length] and contact pressure [stress] at ``xi = 0, 1/2, 1`` of each wall edge, both (edges, 3).

    The gap is the one to the body that the wall faced at rest, NaN where it faced none. The pressure, >= 0, is that of
    the penalty at these points, whichever body presses.
    """
    positions = assembly.positions(assembly.expand(state.displacement))
    nodes = walls.nodes(positions)
    sampled = replace(walls, stations=_PLACES, weights=np.ones((walls.edge_count, len(_PLACES))))
    gap = np.full((walls.edge_count, len(_PLACES)), np.nan)
    edge, first = np.unique(facing.edge, return_index=True)
    points = walls.basis.values(_PLACES) @ nodes[edge]
    body = np.repeat(facing.other[first], len(_PLACES))
    gap[edge] = nearest_on_body(walls, nodes, points.reshape(-1, 2), body).reshape(-1, len(_PLACES))
    pressure = np.zeros_like(gap)
    if assembly.contact is not None:
        contact = PenaltyContact(sampled, assembly.contact.stiffness, assembly.contact.reach).pair(positions)
        partners = contact.kinematics.partners
        np.add.at(pressure, (partners.edge, partners.station), contact.pressures(positions))
    return gap, pressure
