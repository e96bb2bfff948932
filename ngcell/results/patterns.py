"""How elements are drawn: points in their reference coordinates, and the VTK cells that join these.

Up to order 2 one VTK cell shows one element without loss of displacement. In the plane an element takes 2 x 2 cells
from order 3 on, whose points have exact values while VTK's quadratics in between do not; in three dimensions it stays
one cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_QUADRATIC_EDGE = 21
_QUADRATIC_TRIANGLE, _BIQUADRATIC_QUAD = 22, 28
_QUADRATIC_TETRA, _TRIQUADRATIC_HEXAHEDRON, _BIQUADRATIC_WEDGE = 24, 29, 32

#: VTK's nodes of a cell, in half its width: corners, middles of the sides, and a quadrilateral's centre.
_QUAD_NODES = np.array([(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)])
_TRIANGLE_NODES = np.array([(0, 0), (2, 0), (0, 2), (1, 0), (1, 1), (0, 1)])

#: Corners of cells in three dimensions, in reference coordinates, and which of them VTK's further nodes are in the
#: middle of: first edges, then sides, then the whole.
_TETRA_CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
_TETRA_MIDDLES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
_WEDGE_CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
_WEDGE_EDGES = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5)]
_WEDGE_MIDDLES = [*_WEDGE_EDGES, (0, 1, 4, 3), (1, 2, 5, 4), (0, 2, 5, 3)]
_HEX_CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
_HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_HEX_SIDES = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
_HEX_MIDDLES = [*_HEX_EDGES, *_HEX_SIDES, tuple(range(8))]


@dataclass(frozen=True, eq=False)
class Pattern:
    """How an element is drawn.

    Attributes
    ----------
    points : array of float, shape (points, dimension), for an edge (points,)
        Points in its reference coordinates [1].
    cells : array of int, shape (cells, nodes)
        VTK cells of them.
    cell_type : int
        Their VTK type.
    """

    points: Array
    cells: Index
    cell_type: int


def pattern_of(kind: ngsolve.ET, order: int) -> Pattern:
    """Return how elements of a kind and order are drawn; KeyError for kinds that are not drawn."""
    pieces = 1 if order <= 2 else 2
    return {
        ngsolve.ET.QUAD: lambda: _quad_pattern(pieces),
        ngsolve.ET.TRIG: lambda: _triangle_pattern(pieces),
        ngsolve.ET.TET: lambda: _one_cell(_TETRA_CORNERS, _TETRA_MIDDLES, _QUADRATIC_TETRA),
        ngsolve.ET.PRISM: lambda: _one_cell(_WEDGE_CORNERS, _WEDGE_MIDDLES, _BIQUADRATIC_WEDGE),
        ngsolve.ET.HEX: lambda: _one_cell(_HEX_CORNERS, _HEX_MIDDLES, _TRIQUADRATIC_HEXAHEDRON),
    }[kind]()


@singledispatch
def wall_pattern(walls: Surface) -> Pattern:
    """Return how walls are drawn: one cell a facet; VTK lists an edge's two ends first and its middle last."""
    raise NotImplementedError(type(walls))


@wall_pattern.register
def _(walls: EdgeSurface) -> Pattern:
    return Pattern(np.array([0.0, 0.5, 1.0]), np.array([[0, 2, 1]]), _QUADRATIC_EDGE)


@wall_pattern.register
def _(walls: FacetSurface) -> Pattern:
    if walls.basis.corner_count == 3:
        return Pattern(_TRIANGLE_NODES / 2, np.arange(6)[None], _QUADRATIC_TRIANGLE)
    return Pattern(_QUAD_NODES / 2, np.arange(9)[None], _BIQUADRATIC_QUAD)


def _quad_pattern(pieces: int) -> Pattern:
    starts = 2 * np.argwhere(np.ones((pieces, pieces)))
    return _numbered(starts[:, None] + _QUAD_NODES, 2 * pieces, _BIQUADRATIC_QUAD)


def _triangle_pattern(pieces: int) -> Pattern:
    starts = 2 * np.argwhere(np.ones((pieces, pieces)))
    upward = starts[starts.sum(1) < 2 * pieces]
    downward = starts[starts.sum(1) < 2 * pieces - 2] + 2
    nodes = np.concatenate([upward[:, None] + _TRIANGLE_NODES, downward[:, None] - _TRIANGLE_NODES])
    return _numbered(nodes, 2 * pieces, _QUADRATIC_TRIANGLE)


def _numbered(nodes: Index, width: int, cell_type: int) -> Pattern:
    """Number the distinct nodes of cells, (cells, nodes, 2), given on a lattice of `width` intervals."""
    points, number = np.unique(nodes.reshape(-1, 2), axis=0, return_inverse=True)
    return Pattern(points / width, number.reshape(nodes.shape[:2]), cell_type)


def _one_cell(corners: Sequence[tuple[int, ...]], middles: Sequence[tuple[int, ...]], cell_type: int) -> Pattern:
    at = np.array(corners, dtype=float)
    points = np.concatenate([at, [at[list(middle)].mean(0) for middle in middles]])
    return Pattern(points, np.arange(len(points))[None], cell_type)
