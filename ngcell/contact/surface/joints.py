"""Where walls in three dimensions meet: sides that two faces of a body share, and by how much the wall turns there.

Side k of a face runs from its corner k to the next one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.facets import FaceBasis, vertices
from ngcell.contact.surface.walls import Walls

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_ON_SIDE = 1e-9


@dataclass(frozen=True, eq=False)
class Joints:
    """Shared sides; all arrays have shape (joints, 2), one column a face.

    Attributes
    ----------
    face, side : array of int
        The two faces, and which side of each.
    """

    face: Index
    side: Index


def find_joints(walls: Walls) -> Joints:
    """Return all sides that two faces share."""
    vertex = vertices(walls)
    corners = vertex.shape[1]
    ends = np.sort(np.stack([vertex, np.roll(vertex, -1, axis=1)], axis=-1), axis=-1).reshape(-1, 2)
    order = np.lexsort(ends.T)
    same = np.flatnonzero((np.diff(ends[order], axis=0) == 0).all(1))
    face, side = np.divmod(np.stack([order[same], order[same + 1]], axis=1), corners)
    return Joints(face, side)


def exterior_angle_at(walls: Walls, nodes: Array) -> Array:
    """Return the angle by which the wall turns in the middle of each side, shape (faces, corners).

    In radians, positive at convex sides; 0 where the wall ends. `nodes` has shape (faces, nodes, 3).
    """
    joints, basis = find_joints(walls), walls.basis
    middle = (basis.corners + np.roll(basis.corners, -1, axis=0)) / 2
    normals, inwards = [], []
    for face, side in zip(joints.face.T, joints.side.T, strict=True):
        tangents = [
            np.einsum("pi,pid->pd", basis.values(middle[side], along), nodes[face]) for along in walls.directions
        ]
        normal = np.cross(*tangents) * walls.side[face, None]
        normals.append(normal / np.linalg.norm(normal, axis=1)[:, None])
        centre = basis.values(basis.centre[None])[0] @ nodes[face]
        inwards.append(centre - walls.places(face, middle[side], nodes))
    angle = np.arccos(np.clip(np.einsum("pd,pd->p", *normals), -1, 1))
    angle = np.where(np.einsum("pd,pd->p", normals[0], inwards[1]) > 0, -angle, angle)
    exterior_angle = np.zeros((walls.edge_count, len(middle)))
    exterior_angle[joints.face, joints.side] = angle[:, None]
    return exterior_angle


def numbered(walls: Walls, lattice: FaceBasis, sharp: NDArray[np.bool_]) -> Index:
    """Return numbers for functions at the nodes of a lattice on each face, shape (faces, nodes).

    Functions on a side are shared by the faces that meet there. Where a side is sharp, `sharp` of shape (faces,
    corners), walls end: there each function joins the nearest one of its face that is not on that side, preferably
    one on no sharp side at all.
    """
    from ngcell.geometry.near import components

    own = np.arange(walls.edge_count * len(lattice.nodes)).reshape(walls.edge_count, -1)
    on_side, joints, vertex = _on_sides(lattice), find_joints(walls), vertices(walls)
    smooth = ~sharp[joints.face[:, 0], joints.side[:, 0]]
    (one, two), (side, other) = joints.face[smooth].T, joints.side[smooth].T
    first, second = own[one[:, None], on_side[side]], own[two[:, None], on_side[other]]
    backwards = vertex[one, side] != vertex[two, other]
    second = np.where(backwards[:, None], second[:, ::-1], second)
    shared = components(own.size, first.ravel(), second.ravel())
    joining, joined = _joined(walls, lattice, sharp, shared[own], on_side)
    links = np.concatenate([first.ravel(), joining]), np.concatenate([second.ravel(), joined])
    return components(own.size, *links)[own]


def _on_sides(lattice: FaceBasis) -> Index:
    """Return the nodes on each side, from its first corner to its last, shape (corners, nodes on a side)."""
    start = lattice.corners
    ahead = np.roll(start, -1, axis=0) - start
    away = lattice.nodes - start[:, None]
    height = ahead[:, None, 0] * away[..., 1] - ahead[:, None, 1] * away[..., 0]
    along = np.einsum("cnd,cd->cn", away, ahead)
    sides = [np.flatnonzero(np.abs(level) < _ON_SIDE) for level in height]
    return np.array([side[np.argsort(place[side])] for side, place in zip(sides, along, strict=True)])


def _joined(
    walls: Walls, lattice: FaceBasis, sharp: NDArray[np.bool_], shared: Index, on_side: Index
) -> tuple[Index, Index]:
    """Return functions on sharp sides, and the one that each joins, by their first numbers."""
    face, side = np.nonzero(sharp)
    count = shared.shape[1]
    is_sharp = np.zeros(int(shared.max(initial=0)) + 1, dtype=bool)
    is_sharp[shared[face[:, None], on_side[side]]] = True
    mine = np.repeat(on_side[side], count, axis=1).ravel()
    face, side = (np.repeat(array, on_side.shape[1] * count) for array in (face, side))
    theirs = np.tile(np.arange(count), len(mine) // max(count, 1))
    off = ~(on_side[side] == theirs[:, None]).any(1)
    face, mine, theirs = face[off], mine[off], theirs[off]
    place = lattice_places(walls, lattice)
    apart = np.linalg.norm(place[face, mine] - place[face, theirs], axis=1)
    function, target = shared[face, mine], shared[face, theirs]
    order = np.lexsort((target, apart, is_sharp[target], function))
    first = order[np.diff(function[order], prepend=-1) > 0]
    own = np.arange(shared.size).reshape(shared.shape)
    return own[face[first], mine[first]], own[face[first], theirs[first]]


def lattice_places(walls: Walls, lattice: FaceBasis) -> Array:
    """Return where the nodes of a lattice are at rest, shape (faces, nodes, 3)."""
    return np.asarray(walls.basis.values(lattice.nodes) @ walls.rest)
