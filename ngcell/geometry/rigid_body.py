"""A rigid body beside a tissue: a convex shell, the last body of the mesh, whose outline is prescribed as a whole.

A body whose outline is translated has no strain: as one more elastic body it is rigid exactly, stores no energy, and
needs no contact of its own kind. It is a shell as thin as the cells' walls, since the stiffness of contact follows from
the thickness of what touches.
"""

from __future__ import annotations

from dataclasses import replace

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import INDENTER, BodyMesh
from ngcell.geometry.rounded import Arcs, Rounded
from ngcell.geometry.sections import int32

Array = NDArray[np.float64]

#: Largest share of a rigid body that its shell takes.
_DEEPEST = 0.5


def with_rigid_body(bodies: BodyMesh, outline: Array, arcs: Arcs | None = None) -> BodyMesh:
    """Return the mesh with one more body, whose outline is the boundary region `INDENTER`, a wall.

    Parameters
    ----------
    bodies : BodyMesh
        Bodies in the plane, of quadrilaterals.
    outline : array of float, shape (nodes, 2)
        Nodes of its outline, convex and anticlockwise [length].
    arcs : Arcs, optional
        Arcs that the outline follows from its first nodes on to the next; else it is a polygon.
    """
    mesh, count, first = bodies.mesh.ngmesh, len(outline), bodies.mesh.nv
    middle = (outline.min(0) + outline.max(0)) / 2
    share = min(bodies.thickness / _inner_radius(outline, middle), _DEEPEST)
    mesh.AddPoints(np.ascontiguousarray(np.concatenate([outline, middle + (1 - share) * (outline - middle)])))
    outer = first + np.arange(count)
    ahead = np.roll(outer, -1)
    for dimension, name, elements in (
        (2, INDENTER, np.column_stack([outer, ahead, ahead + count, outer + count])),
        (1, INDENTER, np.column_stack([outer, ahead])),
        (1, f"{INDENTER}-inside", np.column_stack([ahead, outer]) + count),
    ):
        region = mesh.AddRegion(name, dim=dimension)
        mesh.AddElements(dim=dimension, index=region, data=int32(elements), base=0)
    none, rounded = np.zeros(count, dtype=bool), bodies.rounded
    if arcs is not None:
        number = np.arange(len(arcs.radius))
        own = Rounded(len(bodies.body_of_element) + number, arcs, np.tile([0.0, 1.0], (len(number), 1)))
        rounded = own if rounded is None else rounded.joined(own)
    return replace(
        bodies,
        mesh=ngsolve.Mesh(mesh),
        body_of_element=np.append(bodies.body_of_element, np.full(count, bodies.body_count)),
        body_names=(*bodies.body_names, INDENTER),
        wall_names=f"{bodies.wall_names}|{INDENTER}",
        is_filling=None if bodies.is_filling is None else np.append(bodies.is_filling, none),
        thickness_of_body=np.append(bodies.thickness_of_body, bodies.thickness),
        rigid_count=bodies.rigid_count + 1,
        rounded=rounded,
    )


def _inner_radius(outline: Array, middle: Array) -> float:
    """Return the distance of a point from the nearest side of a convex outline [length]."""
    along = np.roll(outline, -1, axis=0) - outline
    away = middle - outline
    return float(((along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]) / np.linalg.norm(along, axis=1)).min())
