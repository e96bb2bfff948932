"""Fields of a state: displacement, volume ratio and stress of the bodies, gap and pressure of their walls.

Every element brings its own points, so that bodies stay apart and stresses, which jump between elements, are
not smoothed. Values at the points are those of the finite element functions; see `ngcell.results.patterns`.
"""

from __future__ import annotations

from collections.abc import Mapping

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.mixed import with_counted_volume
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import stress as cauchy_stress
from ngcell.results.patterns import Pattern, pattern_of, wall_pattern
from ngcell.results.places import element_type, map_points
from ngcell.results.snapshot import Grid

Array = NDArray[np.float64]

#: Names of the fields that snapshots have.
FIELDS = frozenset({"displacement", "J", "cauchy_stress", "von_mises", "cell_id", "free", "rigid", "cell_pressure"})
Index = NDArray[np.int64]


def take_fields(
    problem: Problem,
    at: Configuration,
    *,
    walls: Surface,
    wall_data: Mapping[str, Array],
    body_data: Mapping[str, NDArray[np.generic]],
) -> tuple[Grid, Grid]:
    """Return the fields of a configuration: those in the bodies, and those on the walls.

    Parameters
    ----------
    problem : Problem
        The bodies, all of elements of one kind.
    at : Configuration
        Where they are.
    walls : Surface
        The walls to show.
    wall_data : mapping of str to array of float, shape (facets, points)
        Values at the points that walls are drawn with, such as the normal gap [length], open > 0.
    body_data : mapping of str to array, shape (bodies,)
        One value a body, such as the pressure of what it holds [stress].

    Raises
    ------
    GeometryError
        If the mesh has elements of several kinds, or pyramids.

    Notes
    -----
    Where an element is inverted, at J <= 0, stresses are NaN.
    """
    return _bulk_grid(problem, at.displacement, body_data), _walls_grid(walls, at.displacement, wall_data)


def _bulk_grid(problem: Problem, displacement: Array, body_data: Mapping[str, NDArray[np.generic]]) -> Grid:
    space = problem.space
    kind = element_type(space)
    pattern = pattern_of(kind, space.order)
    places = map_points(space, kind, pattern.points)
    body = space.bodies.body_of_element[places["nr"]]
    gradient = _deformation_gradient(space, displacement, places)
    counted = _with_counted_volume(problem, displacement, gradient, pattern.points)
    stress = cauchy_stress(problem.terms, counted, places["nr"])
    cells = _repeat_cells(pattern, len(places))
    cell_id = body[cells[:, 0]]
    return Grid(
        points=_three_components(ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z)[: space.dimension])(places)),
        cells=cells,
        cell_type=pattern.cell_type,
        point_data={
            "displacement": _three_components(space.function(displacement)(places)),
            "J": np.linalg.det(gradient),
            "cauchy_stress": stress.reshape(-1, 9),
            "von_mises": _von_mises(stress),
        },
        cell_data={"cell_id": cell_id, **{name: values[cell_id] for name, values in body_data.items()}},
    )


def _walls_grid(walls: Surface, displacement: Array, wall_data: Mapping[str, Array]) -> Grid:
    """Return one quadratic cell a wall edge."""
    pattern = wall_pattern(walls)
    order = pattern.cells[0]
    at_nodes = walls.basis.values(pattern.points[order])
    moved = walls.nodes(displacement.reshape(walls.dimension, -1))
    return Grid(
        points=_three_components((at_nodes @ walls.rest).reshape(-1, walls.dimension)),
        cells=np.arange(len(order) * walls.facet_count).reshape(-1, len(order)),
        cell_type=pattern.cell_type,
        point_data={
            "displacement": _three_components((at_nodes @ moved).reshape(-1, walls.dimension)),
            **{name: values[:, order].ravel() for name, values in wall_data.items()},
        },
        cell_data={"cell_id": walls.body},
    )


def _deformation_gradient(space: DisplacementSpace, displacement: Array, places: NDArray[np.void]) -> Array:
    """Return F [1], in the plane that of plane strain, shape (points, 3, 3)."""
    gradient, dimension = np.tile(np.eye(3), (len(places), 1, 1)), space.dimension
    own = ngsolve.Grad(space.function(displacement))(places).reshape(-1, dimension, dimension)
    gradient[:, :dimension, :dimension] += own
    return gradient


def _with_counted_volume(problem: Problem, displacement: Array, gradient: Array, points: Array) -> Array:
    """Return deformation gradients with the volume ratio that the stored energy counts; see `ngcell.mechanics.mixed`.
    """
    marked = [is_mixed for term in problem.terms if (is_mixed := term.is_mixed) is not None]
    mixed = np.any(marked, axis=0) if marked else np.zeros(1, dtype=bool)
    if not mixed.any():
        return gradient
    counted = with_counted_volume(problem.space, displacement, gradient, points)
    return np.where(np.repeat(mixed, len(points))[:, None, None], counted, gradient)


def _von_mises(stress: Array) -> Array:
    mean = np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3
    deviator = stress - mean * np.eye(3)
    return np.asarray(np.sqrt(1.5 * np.einsum("pij,pij->p", deviator, deviator)))


def _repeat_cells(pattern: Pattern, point_count: int) -> Index:
    first = np.arange(0, point_count, len(pattern.points))
    return (first[:, None, None] + pattern.cells).reshape(-1, pattern.cells.shape[1])


def _three_components(vectors: Array) -> Array:
    return np.column_stack([vectors, np.zeros((len(vectors), 3 - vectors.shape[1]))])
