"""Gap and contact pressure along the walls, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.contact.pairing.search import nearest_on_body
from ngcell.contact.surface.walls import WallPoints, Walls
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import contact_pressures
from ngcell.results.patterns import wall_pattern

Array = NDArray[np.float64]


def wall_fields(walls: Walls, facing: FacingWalls, problem: Problem, at: Configuration) -> tuple[Array, Array]:
    """Return gap [length] and contact pressure [stress] at the points that walls are drawn with, both (edges, points).

    The gap is the one to the body that the wall faced at rest, NaN where it faced none. The pressure, >= 0, is the
    true one, for each deformed length, whichever body presses.
    """
    nodes = walls.nodes(at.positions)
    places = wall_pattern(walls).points
    count = len(places)
    gap = np.full((walls.edge_count, count), np.nan)
    edge, first = np.unique(facing.edge, return_index=True)
    points = walls.basis.values(places) @ nodes[edge]
    body = np.repeat(facing.other[first], count)
    gap[edge] = nearest_on_body(walls, nodes, points.reshape(-1, walls.dimension), body).reshape(-1, count)
    everywhere = WallPoints(
        np.repeat(np.arange(walls.edge_count), count),
        np.tile(places, (walls.edge_count,) + (1,) * (walls.dimension - 2)),
        np.zeros(gap.size),
    )
    nominal = contact_pressures(problem.terms, at, everywhere)
    if nominal is None:
        return gap, np.zeros_like(gap)
    return gap, nominal.reshape(gap.shape) * walls.stretch(walls.rest, places) / walls.stretch(nodes, places)
