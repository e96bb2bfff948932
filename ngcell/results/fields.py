"""Snapshots of a state: displacement, volume ratio and stress of the bodies, gap and pressure of their walls.

Every element brings its own points, so that bodies stay apart and stresses, which jump between elements, are
not smoothed. Values at the points are those of the finite element functions. Up to order 2 one VTK cell shows
one element without loss of displacement (quadrilaterals of VTK type 28, triangles of type 22); from order 3
on it takes 2 x 2 such cells, whose points carry exact values while VTK's quadratics in between do not.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.assembly import Assembly
from ngcell.contact.walls import Walls
from ngcell.errors import GeometryError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.snapshot import Grid, Snapshot

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_BIQUADRATIC_QUAD = 28
_QUADRATIC_TRIANGLE = 22
_QUADRATIC_EDGE = 21

#: VTK's nodes of a cell, in half its width: corners, middles of the sides, and a quadrilateral's centre.
_QUAD_NODES = np.array([(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)])
_TRIANGLE_NODES = np.array([(0, 0), (2, 0), (0, 2), (1, 0), (1, 1), (0, 1)])


@dataclass(frozen=True, eq=False)
class _Pattern:
    """How an element is drawn: points in its reference coordinates, (points, 2), and cells of them."""

    points: Array
    cells: Index
    cell_type: int


def take_snapshot(
    assembly: Assembly,
    displacement: Array,
    *,
    walls: Walls,
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
        The planar bodies, all of quadrilaterals or all of triangles.
    displacement : array of float, shape (unknowns,)
        The displacement [length]; in a tied assembly slaves follow their masters.
    walls : Walls
        The walls to show.
    step : int
        Number of the accepted step, from 0.
    load_factor : float
        Share of the case's full load, in [0, 1].
    plate_displacement : float
        Length of the displacement of the moved plate [length], >= 0.
    gap, contact_pressure : array of float, shape (edges, 3)
        Normal gap [length], open > 0, and pressure [stress], >= 0, at ``xi = 0, 1/2, 1`` of each wall edge.
    free_bodies : collection or array of int
        Numbers of the bodies that nothing holds.
    cell_pressure : array of float, shape (bodies,), optional
        Pressure of what each body holds [stress].

    Raises
    ------
    GeometryError
        If the mesh has other elements than only quadrilaterals or only triangles.

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

    They are taken over the quadrature points of the stored energy, and over the corners of each element, the
    middles of its sides and, for a quadrilateral, its centre; from order 3 on over those of its quarters.

    Parameters
    ----------
    assembly : Assembly
        The planar bodies, all of quadrilaterals or all of triangles.
    displacement : array of float, shape (unknowns,)
        The displacement [length]; in a tied assembly slaves follow their masters.

    Raises
    ------
    GeometryError
        If the mesh has other elements than only quadrilaterals or only triangles.
    """
    space = assembly.space
    kind = _element_type(space)
    quadrature = ngsolve.IntegrationRule(kind, 2 * space.order).points
    lattice = _pattern(kind, space.order).points
    places = _map(space, kind, np.vstack([np.array(quadrature)[:, :2], lattice]))
    jacobian = np.linalg.det(_deformation_gradient(space, assembly.expand(displacement), places))
    return float(jacobian.min()), float(jacobian.max())


def _bulk_grid(
    assembly: Assembly, displacement: Array, free_bodies: Collection[int] | Index, cell_pressure: Array | None
) -> Grid:
    space = assembly.space
    kind = _element_type(space)
    pattern = _pattern(kind, space.order)
    places = _map(space, kind, pattern.points)
    body = space.bodies.body_of_element[places["nr"]]
    gradient = _deformation_gradient(space, displacement, places)
    stress = _cauchy_stress(assembly, gradient, places["nr"])
    cells = _repeat_cells(pattern, len(places))
    cell_id = body[cells[:, 0]]
    held = {} if cell_pressure is None else {"cell_pressure": cell_pressure[cell_id]}
    return Grid(
        points=_in_space(ngsolve.CF((ngsolve.x, ngsolve.y))(places)),
        cells=cells,
        cell_type=pattern.cell_type,
        point_data={
            "displacement": _in_space(space.function(displacement)(places)),
            "J": np.linalg.det(gradient),
            "cauchy_stress": stress.reshape(-1, 9),
            "von_mises": _von_mises(stress),
        },
        cell_data={"cell_id": cell_id, "free": np.isin(cell_id, list(free_bodies)).astype(np.int64), **held},
    )


def _walls_grid(walls: Walls, displacement: Array, gap: Array, contact_pressure: Array) -> Grid:
    """Return one quadratic edge a wall edge; VTK lists its two ends first and its middle last."""
    at_nodes = walls.basis.values(np.array([0.0, 1.0, 0.5]))
    moved = walls.nodes(displacement.reshape(2, -1))
    ends_first = [0, 2, 1]
    return Grid(
        points=_in_space((at_nodes @ walls.rest).reshape(-1, 2)),
        cells=np.arange(3 * walls.edge_count).reshape(-1, 3),
        cell_type=_QUADRATIC_EDGE,
        point_data={
            "displacement": _in_space((at_nodes @ moved).reshape(-1, 2)),
            "gap": gap[:, ends_first].ravel(),
            "contact_pressure": contact_pressure[:, ends_first].ravel(),
        },
        cell_data={"cell_id": walls.body},
    )


def _element_type(space: DisplacementSpace) -> ngsolve.ET:
    kinds = {element.type for element in space.bodies.mesh.Elements(ngsolve.VOL)}
    if kinds not in ({ngsolve.ET.QUAD}, {ngsolve.ET.TRIG}):
        names = ", ".join(sorted(kind.name for kind in kinds)) or "no elements"
        raise GeometryError(
            f"the mesh holds {names}; only QUAD or only TRIG is possible: mesh all bodies alike"
        )
    return kinds.pop()


def _map(space: DisplacementSpace, kind: ngsolve.ET, points: Array) -> NDArray[np.void]:
    """Return where reference points lie in all elements, element by element; `nr` is the element's number."""
    rule = ngsolve.IntegrationRule(points=[tuple(point) for point in points], weights=[0.0] * len(points))
    return np.asarray(space.bodies.mesh.MapToAllElements({kind: rule}, ngsolve.VOL))


def _deformation_gradient(space: DisplacementSpace, displacement: Array, places: NDArray[np.void]) -> Array:
    """Return F [1] of plane strain, shape (points, 3, 3)."""
    gradient = np.tile(np.eye(3), (len(places), 1, 1))
    gradient[:, :2, :2] += ngsolve.Grad(space.function(displacement))(places).reshape(-1, 2, 2)
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


def _pattern(kind: ngsolve.ET, order: int) -> _Pattern:
    pieces = 1 if order <= 2 else 2
    return _quad_pattern(pieces) if kind == ngsolve.ET.QUAD else _triangle_pattern(pieces)


def _quad_pattern(pieces: int) -> _Pattern:
    starts = 2 * np.argwhere(np.ones((pieces, pieces)))
    return _numbered(starts[:, None] + _QUAD_NODES, 2 * pieces, _BIQUADRATIC_QUAD)


def _triangle_pattern(pieces: int) -> _Pattern:
    starts = 2 * np.argwhere(np.ones((pieces, pieces)))
    upward = starts[starts.sum(1) < 2 * pieces]
    downward = starts[starts.sum(1) < 2 * pieces - 2] + 2
    nodes = np.concatenate([upward[:, None] + _TRIANGLE_NODES, downward[:, None] - _TRIANGLE_NODES])
    return _numbered(nodes, 2 * pieces, _QUADRATIC_TRIANGLE)


def _numbered(nodes: Index, width: int, cell_type: int) -> _Pattern:
    """Number the distinct nodes of cells, (cells, nodes, 2), given on a lattice of `width` intervals."""
    points, number = np.unique(nodes.reshape(-1, 2), axis=0, return_inverse=True)
    return _Pattern(points / width, number.reshape(nodes.shape[:2]), cell_type)


def _repeat_cells(pattern: _Pattern, point_count: int) -> Index:
    first = np.arange(0, point_count, len(pattern.points))
    return (first[:, None, None] + pattern.cells).reshape(-1, pattern.cells.shape[1])


def _in_space(vectors: Array) -> Array:
    return np.column_stack([vectors, np.zeros(len(vectors))])
