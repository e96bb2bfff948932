"""Gap and contact pressure along the walls, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.contact.pairing.search import nearest_on_body
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import contact_pressures
from ngcell.results.patterns import wall_pattern

Array = NDArray[np.float64]


def wall_fields(walls: Surface, facing: FacingWalls, problem: Problem, at: Configuration) -> tuple[Array, Array]:
    """Return gap [length] and contact pressure [stress] at the points that walls are drawn with, both (facets, points).

    The gap is the one to the body that the wall faced at rest, NaN where it faced none. The pressure, >= 0, is the
    true one, per deformed length or area, whichever body presses.
    """
    nodes = walls.nodes(at.positions)
    places = wall_pattern(walls).points
    count = len(places)
    gap = np.full((walls.facet_count, count), np.nan)
    facet, first = np.unique(facing.facet, return_index=True)
    points = walls.basis.values(places) @ nodes[facet]
    body = np.repeat(facing.other[first], count)
    gap[facet] = nearest_on_body(walls, nodes, points.reshape(-1, walls.dimension), body).reshape(-1, count)
    everywhere = walls.on_each_facet(places, np.zeros_like(gap))
    nominal = contact_pressures(problem.terms, at, everywhere)
    if nominal is None:
        return gap, np.zeros_like(gap)
    return gap, nominal.reshape(gap.shape) * walls.stretch(walls.rest, places) / walls.stretch(nodes, places)
