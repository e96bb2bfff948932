"""Walls that nothing can touch: they slide in a plane that stays where it is, and all bodies are on one side of it.

Such a plane is one of symmetry, or a frictionless guide. A corner where a guided side ends is no corner of what the
bodies stand for: were the side a wall, points beside it that are pressed into the other body would be nearest to that
body's guided side, and be pushed along the plane instead of back.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import BodyMesh
from ngcell.scene.bodies import BodySupport

Array = NDArray[np.float64]

#: Share of the extent, and of a facet, that is round-off.
_ROUND_OFF = 1e-9


def without_guided_walls(bodies: BodyMesh, supports: Sequence[BodySupport], kept: Iterable[str] = ()) -> BodyMesh:
    """Return bodies whose guided walls are walls no more, as long as others are left.

    Parameters
    ----------
    bodies : BodyMesh
        The bodies.
    supports : sequence of BodySupport
        All of them, of the bodies' dimension.
    kept : iterable of str
        Boundaries that stay walls.
    """
    walls = [name for name in bodies.wall_names.split("|") if name]
    points = np.array([vertex.point for vertex in bodies.mesh.vertices])
    candidates = {support.boundary for support in supports} & set(walls) - set(kept)
    guided = {name for name in candidates if _is_guided(bodies, name, supports, points)}
    left = [name for name in walls if name not in guided]
    return replace(bodies, wall_names="|".join(left)) if left and guided else bodies


def _is_guided(bodies: BodyMesh, name: str, supports: Sequence[BodySupport], points: Array) -> bool:
    """Return whether a boundary lies in a plane that it cannot leave and that no body is beyond, or is moved beyond."""
    supported = [(support, _vertices(bodies, support.boundary)) for support in supports]
    own = _vertices(bodies, name)
    held = [support for support in supports if support.boundary == name][-1]
    slack = _ROUND_OFF * float(np.ptp(bodies.extent, axis=0).max())
    for axis in map(int, np.flatnonzero(held.components)):
        plane = points[own, axis]
        if np.ptp(plane) > slack or not _is_flat(bodies, name, axis) or np.abs(_moved(held, points[own], axis)).max():
            continue
        driven = [points[other, axis] + _moved(support, points[other], axis) for support, other in supported]
        reached = np.concatenate([points[:, axis], *driven]) - plane[0]
        if reached.max() <= slack or reached.min() >= -slack:
            return True
    return False


def _moved(support: BodySupport, points: Array, axis: int) -> Array:
    """Return the displacement along an axis at load factor 1 that a support prescribes [length], shape (points,)."""
    if not support.components[axis]:
        return np.zeros(len(points))
    return np.asarray(points @ np.array(support.gradient[axis]) + support.translation[axis])


def _vertices(bodies: BodyMesh, name: str) -> NDArray[np.int64]:
    found = {vertex.nr for facet in bodies.mesh.Boundaries(name).Elements() for vertex in facet.vertices}
    return np.array(sorted(found), dtype=np.int64)


def _is_flat(bodies: BodyMesh, name: str, axis: int) -> bool:
    """Return whether the normals of all facets of a boundary, however curved, are along an axis."""
    region, normal = bodies.mesh.Boundaries(name), ngsolve.specialcf.normal(bodies.dimension)[axis]
    along, whole = (ngsolve.Integrate(what, bodies.mesh, definedon=region) for what in (ngsolve.sqrt(normal**2), 1.0))
    return bool(along >= (1 - _ROUND_OFF) * whole)
