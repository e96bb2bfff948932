"""Snapshots of a state: displacement, volume ratio and stress of the bodies, gap and pressure of their walls.

Every element brings its own points, so that bodies stay apart and stresses, which jump between elements, are
not smoothed. Values at the points are those of the finite element functions; see `ngcell.results.patterns`.
"""

from __future__ import annotations

from collections.abc import Collection

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.surface import Surface
from ngcell.errors import GeometryError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.assembly import Assembly
from ngcell.results.patterns import Pattern, pattern_of, wall_pattern
from ngcell.results.snapshot import Grid, Snapshot

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Elements that can be drawn, in the plane and in three dimensions; a mesh has one kind only.
_DRAWN = ({ngsolve.ET.QUAD}, {ngsolve.ET.TRIG}, {ngsolve.ET.TET}, {ngsolve.ET.HEX}, {ngsolve.ET.PRISM})


def take_snapshot(
    assembly: Assembly,
    displacement: Array,
    *,
    walls: Surface,
    step: int,
    load_factor: float,
    plate_displacement: float,
    gap: Array,
    contact_pressure: Array,
    free_bodies: Collection[int] | Index = frozenset(),
    cell_pressure: Array | None = None,
) -> Snapshot:
    """Return the fields of a state.

    Parameters
    ----------
    assembly : Assembly
        The bodies, all of elements of one kind.
    displacement : array of float, shape (unknowns,)
        The displacement [length]; in a tied assembly slaves follow their masters.
    walls : Surface
        The walls to show.
    step : int
        Number of the accepted step, from 0.
    load_factor : float
        Share of the case's full load, in [0, 1].
    plate_displacement : float
        Length of the displacement of the moved plate [length], >= 0.
    gap, contact_pressure : array of float, shape (edges, points)
        Normal gap [length], open > 0, and pressure [stress], >= 0, at the points that walls are drawn with.
    free_bodies : collection or array of int
        Numbers of the bodies that nothing holds.
    cell_pressure : array of float, shape (bodies,), optional
        Pressure of what each body holds [stress].

    Raises
    ------
    GeometryError
        If the mesh has elements of several kinds, or pyramids.

    Notes
    -----
    Where an element is inverted, at J <= 0, stresses are NaN.
    """
    full = assembly.expand(displacement)
    return Snapshot(
        step=step,
        load_factor=load_factor,
        plate_displacement=plate_displacement,
        bulk=_bulk_grid(assembly, full, free_bodies, cell_pressure),
        walls=_walls_grid(walls, full, gap, contact_pressure),
    )


def jacobian_range(assembly: Assembly, displacement: Array) -> tuple[float, float]:
    """Return the smallest and the largest J = det F [1].

    They are taken over the quadrature points of the stored energy, and over the points that elements are drawn with.

    Parameters
    ----------
    assembly : Assembly
        The bodies, all of elements of one kind.
    displacement : array of float, shape (unknowns,)
        The displacement [length]; in a tied assembly slaves follow their masters.

    Raises
    ------
    GeometryError
        If the mesh has elements of several kinds, or pyramids.
    """
    space = assembly.space
    kind = _element_type(space)
    quadrature = ngsolve.IntegrationRule(kind, 2 * space.order).points
    lattice = pattern_of(kind, space.order).points
    places = _map(space, kind, np.vstack([np.array(quadrature)[:, : space.dimension], lattice]))
    jacobian = np.linalg.det(_deformation_gradient(space, assembly.expand(displacement), places))
    return float(jacobian.min()), float(jacobian.max())


def _bulk_grid(
    assembly: Assembly, displacement: Array, free_bodies: Collection[int] | Index, cell_pressure: Array | None
) -> Grid:
    space = assembly.space
    kind = _element_type(space)
    pattern = pattern_of(kind, space.order)
    places = _map(space, kind, pattern.points)
    body = space.bodies.body_of_element[places["nr"]]
    gradient = _deformation_gradient(space, displacement, places)
    stress = _cauchy_stress(assembly, gradient, places["nr"])
    cells = _repeat_cells(pattern, len(places))
    cell_id = body[cells[:, 0]]
    held = {} if cell_pressure is None else {"cell_pressure": cell_pressure[cell_id]}
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
        cell_data={"cell_id": cell_id, "free": np.isin(cell_id, list(free_bodies)).astype(np.int64), **held},
    )


def _walls_grid(walls: Surface, displacement: Array, gap: Array, contact_pressure: Array) -> Grid:
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
            "gap": gap[:, order].ravel(),
            "contact_pressure": contact_pressure[:, order].ravel(),
        },
        cell_data={"cell_id": walls.body},
    )


def _element_type(space: DisplacementSpace) -> ngsolve.ET:
    kinds = {element.type for element in space.bodies.mesh.Elements(ngsolve.VOL)}
    if kinds not in _DRAWN:
        names = ", ".join(sorted(kind.name for kind in kinds)) or "no elements"
        possible = " or ".join(f"only {kind.name}" for one in _DRAWN for kind in one)
        raise GeometryError(f"the mesh holds {names}; {possible} is possible: mesh all bodies alike")
    return kinds.pop()


def _map(space: DisplacementSpace, kind: ngsolve.ET, points: Array) -> NDArray[np.void]:
    """Return where reference points lie in all elements, element by element; `nr` is the element's number."""
    rule = ngsolve.IntegrationRule(points=[tuple(point) for point in points], weights=[0.0] * len(points))
    return np.asarray(space.bodies.mesh.MapToAllElements({kind: rule}, ngsolve.VOL))


def _deformation_gradient(space: DisplacementSpace, displacement: Array, places: NDArray[np.void]) -> Array:
    """Return F [1], in the plane that of plane strain, shape (points, 3, 3)."""
    gradient, dimension = np.tile(np.eye(3), (len(places), 1, 1)), space.dimension
    own = ngsolve.Grad(space.function(displacement))(places).reshape(-1, dimension, dimension)
    gradient[:, :dimension, :dimension] += own
    return gradient


def _cauchy_stress(assembly: Assembly, gradient: Array, element: Index) -> Array:
    stress = np.empty_like(gradient)
    for law, members in assembly.bulk.materials():
        mine = members[element]
        with np.errstate(divide="ignore", invalid="ignore"):
            stress[mine] = law.cauchy_stress(gradient[mine])
            if law.fibres is not None:
                direction = assembly.bulk.fibre_direction[element[mine]]
                stress[mine] += law.fibres.cauchy_stress(gradient[mine], direction)
    return stress


def _von_mises(stress: Array) -> Array:
    mean = np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3
    deviator = stress - mean * np.eye(3)
    return np.asarray(np.sqrt(1.5 * np.einsum("pij,pij->p", deviator, deviator)))


def _repeat_cells(pattern: Pattern, point_count: int) -> Index:
    first = np.arange(0, point_count, len(pattern.points))
    return (first[:, None, None] + pattern.cells).reshape(-1, pattern.cells.shape[1])


def _three_components(vectors: Array) -> Array:
    return np.column_stack([vectors, np.zeros((len(vectors), 3 - vectors.shape[1]))])
