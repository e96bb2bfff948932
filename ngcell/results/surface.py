"""Gap and contact pressure along the walls, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.contact.pairing.search import nearest_on_body
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import contact_pressures, interaction
from ngcell.results.patterns import wall_pattern

Array = NDArray[np.float64]


#: Share of the largest pressure from which on a point counts as in contact.
_PRESSED = 1e-2


def pressed_lengths(walls: Surface, pairs: NDArray[np.int64], problem: Problem, at: Configuration) -> Array:
    """Return the deformed length, or area, on which each pair of bodies is in contact, shape (pairs,).

    It is that of the first body's facets which the other body presses, as far as the pressure on them, whichever body
    presses, exceeds a hundredth of the largest there.
    """
    acting, found = interaction(problem.terms, at), np.zeros(len(pairs))
    nodes, places = walls.nodes(at.positions), walls.quadrature_points
    nominal = contact_pressures(problem.terms, at, walls.on_each_facet(places, walls.weights))
    if nominal is None:
        return found
    ratio = walls.stretch(nodes, places) / walls.stretch(walls.rest, places)
    pressure, length = nominal.reshape(walls.weights.shape) / ratio, walls.weights * ratio
    for number, (one, two) in enumerate(pairs):
        turns = enumerate(((one, two), (two, one)))
        mine = [acting.facets[(acting.bodies == turn).all(1), side] for side, turn in turns]
        facets = np.unique(np.concatenate(mine))
        if len(facets):
            is_pressed = pressure[facets] > _PRESSED * pressure[facets].max()
            found[number] = length[facets][is_pressed].sum()
    return found


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
