"""Outlines of bodies in the plane: their boundary edges, chained by common unknowns to closed loops."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from weakref import WeakKeyDictionary

import ngsolve
import numpy as np
import shapely
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface, find_edges
from ngcell.contact.surface.loops import anticlockwise, closed_loops, signed_area
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Straight pieces that stand for one curved edge.
_CHORDS = 16


class Outlines:
    """The closed loops of boundary edges, each with its body on the left.

    Parameters
    ----------
    walls : EdgeSurface
        The edges.

    Attributes
    ----------
    shells : dict of int to array of int
        The edges around each body that they go around, in order.
    holes : dict of int to list of array of int
        Those around its holes.
    """

    def __init__(self, walls: EdgeSurface) -> None:
        self._basis, self._side = walls.basis, walls.side
        corners = anticlockwise(walls.side, walls.rest)[:, 0]
        self.shells: dict[int, Index] = {}
        self.holes: dict[int, list[Index]] = defaultdict(list)
        for loop in closed_loops(walls):
            body = int(walls.body[loop[0]])
            if signed_area(corners[loop]) > 0:
                self.shells[body] = loop
            else:
                self.holes[body].append(loop)

    def rings(self, nodes: Array) -> dict[int, list[Array]]:
        """Return the deformed loops of each body, the shell first, as corners of polygons, each (corners, 2).

        Parameters
        ----------
        nodes : array of float, shape (edges, order + 1, 2)
            Deformed positions of the Lagrange nodes of the edges [length].
        """
        values = self._basis.values(np.linspace(0, 1, chords(self._basis.order) + 1)[:-1])
        lines = values @ anticlockwise(self._side, nodes)
        return {
            body: [lines[loop].reshape(-1, 2) for loop in (shell, *self.holes[body])]
            for body, shell in self.shells.items()
        }

    def polygons(self, nodes: Array) -> tuple[Index, NDArray[np.object_]]:
        """Return the bodies with a closed outline, shape (bodies,), and their deformed polygons."""
        polygons = [shapely.Polygon(shell, holes) for shell, *holes in self.rings(nodes).values()]
        return np.array(list(self.shells), dtype=np.int64), np.array(polygons, dtype=object)


def outlines(walls: EdgeSurface) -> Outlines:
    """Return the outlines that walls form, found once."""
    if walls not in _outlines:
        _outlines[walls] = Outlines(walls)
    return _outlines[walls]


def all_boundaries(space: DisplacementSpace) -> EdgeSurface:
    """Return the whole boundary of all bodies, lumens included, as if it were walls, found once.

    An edge between two elements, as that of a wall and what fills its lumen, is no boundary.
    """
    if space not in _boundaries:
        mesh = space.mesh
        inner = {element.mat for element in mesh.Elements(ngsolve.BND) if len(mesh[element.edges[0]].elements) > 1}
        names = "|".join(sorted(set(mesh.GetBoundaries()) - inner))
        _boundaries[space] = find_edges(replace(space.bodies, wall_names=names), space.scalar, space.rest)
    return _boundaries[space]


#: What was found of walls and bodies that are still in use.
_outlines: WeakKeyDictionary[EdgeSurface, Outlines] = WeakKeyDictionary()
_boundaries: WeakKeyDictionary[DisplacementSpace, EdgeSurface] = WeakKeyDictionary()


def chords(order: int) -> int:
    """Return the number of straight pieces that stand for an edge of an order."""
    return 1 if order == 1 else _CHORDS
