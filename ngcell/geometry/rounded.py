"""Round corners of rings, and elements whose outer sides are arcs.

Nodes stand on chords of the arcs (`ARC_EDGES` to half a corner). From there elements are moved onto the arcs by
polynomials of the order of the displacement, so that outlines turn by next to nothing where elements meet: along chords
a wall would slide over kinks, each of which holds it like a notch. Graded elements are parts of those of the grade
before in the chords' geometry, and their arcs, too, where the order resolves them.
"""

from __future__ import annotations

from dataclasses import dataclass

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.outlines import Outlines

ARC_EDGES = 2
#: Angle in radians below which a corner is none: nothing is rounded there.
_STRAIGHT = 1e-3

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Arcs:
    """Arcs that sides of elements lie on.

    Attributes
    ----------
    sharp, centre : array of float, shape (n, 2)
        The corner that each arc rounds, and its centre [length].
    radius : array of float, shape (n,)
        Its radius [length].
    way : array of float, shape (n, 2)
        Direction from the corner along the side of the sharp outline.
    distance : array of float, shape (n, 2)
        Distances from the corner along it, from which rays to the centre meet the ends of the element's side [length].
    chord : array of float, shape (n, 2, 2)
        Where the nodes at these ends stand [length].
    """

    sharp: Array
    centre: Array
    radius: Array
    way: Array
    distance: Array
    chord: Array

    def sagitta(self, share: Array) -> Array:
        """Return the way from the chord to the arc at shares of the element's side, shape (n, shares, 2)."""
        one, two = (1 - share)[:, None], share[:, None]
        along = self.distance @ np.stack([1 - share, share])
        place = self.sharp[:, None] + self.way[:, None] * along[..., None]
        arc = _on_circle(place, self.centre[:, None], self.radius[:, None])
        return np.asarray(arc - one * self.chord[:, :1] - two * self.chord[:, 1:])

    def chosen(self, numbers: Index) -> Arcs:
        """Return the arcs with these numbers."""
        return Arcs(**{name: value[numbers] for name, value in vars(self).items()})


def arcs_between(starts: Array, ends: Array, centre: Array, radius: float) -> Arcs:
    """Return the arcs of a circle from its points, shape (n, 2), to others [length]."""
    length = np.linalg.norm(ends - starts, axis=1)
    return Arcs(
        sharp=starts,
        centre=np.tile(centre, (len(starts), 1)),
        radius=np.full(len(starts), radius),
        way=(ends - starts) / length[:, None],
        distance=np.column_stack([0 * length, length]),
        chord=np.stack([starts, ends], axis=1),
    )


@dataclass(frozen=True, eq=False)
class Rounded:
    """Elements that follow the arcs on the outer side of their wall.

    Attributes
    ----------
    element : array of int, shape (n,)
        Quadrilaterals or hexahedra, whose first node and second node stand along the outer side of their layer.
    arcs : Arcs
        The arc behind each.
    layer : array of float, shape (n, 2)
        Where its layer begins and ends, as shares of the wall from outside.
    """

    element: Index
    arcs: Arcs
    layer: Array

    def repeated(self, element: Index) -> Rounded:
        """Return the same for several elements each, of these numbers, shape (n, times)."""
        each = np.repeat(np.arange(len(self.element)), element.shape[1])
        return Rounded(element.ravel(), self.arcs.chosen(each), self.layer[each])

    def joined(self, others: Rounded) -> Rounded:
        """Return these elements and others."""
        arcs = {name: np.concatenate([value, vars(others.arcs)[name]]) for name, value in vars(self.arcs).items()}
        element = np.concatenate([self.element, others.element])
        return Rounded(element, Arcs(**arcs), np.concatenate([self.layer, others.layer]))

    def curving(self, mesh: ngsolve.Mesh, order: int) -> ngsolve.GridFunction:
        """Return what moves elements of a mesh onto their arcs, by polynomials of this order [length]."""
        space = ngsolve.H1(mesh, order=order)
        moved, inverse = np.zeros((mesh.dim, space.ndof)), dict[tuple[int, ...], Array]()
        share = np.linspace(0, 1, order + 1)
        sagitta = self.arcs.sagitta(share)
        within = 1 - self.layer @ np.stack([1 - share, share])
        grid = np.stack(np.meshgrid(*[share] * mesh.dim, indexing="ij"), axis=-1).reshape(-1, mesh.dim)
        at = np.einsum("nxd,ny->nxyd", sagitta, within)
        if mesh.dim == 3:
            at = np.repeat(at[:, :, :, None], order + 1, axis=3)
        at = at.reshape(len(at), len(grid), 2)
        for number, values in zip(self.element, at, strict=True):
            element = mesh[ngsolve.ElementId(ngsolve.VOL, int(number))]
            vertices = [vertex.nr for vertex in element.vertices]
            pattern = tuple(sorted(range(len(vertices)), key=vertices.__getitem__))
            if pattern not in inverse:  # shape functions are the same on elements with vertices in the same order
                shape = space.GetFE(element).CalcShape
                inverse[pattern] = np.linalg.inv([np.asarray(shape(*place)).ravel() for place in grid])
            moved[:2, list(space.GetDofNrs(element))] = (inverse[pattern] @ values).T
        function = ngsolve.GridFunction(ngsolve.VectorH1(mesh, order=order))
        function.vec.FV().NumPy()[:] = moved.ravel()
        return function


def round_corners(sharp: Array, outlines: Outlines, side: Index, place: Array, cut: float) -> Array:
    """Move the points of sharp outlines that corners lose onto the chords of the arcs.

    Parameters
    ----------
    sharp : array of float, shape (nodes, 2)
        Nodes of the outlines [length].
    outlines : Outlines
        The cells.
    side : array of int, shape (nodes,)
        Side that each node stands on.
    place : array of float, shape (nodes,)
        Where it stands there, in [0, 1).
    cut : float
        Length of side that a corner loses [length], > 0.
    """
    rounded = sharp.copy()
    length = outlines.lengths[side]
    for corner, sign, distance in ((side, 1, place * length), (outlines.ahead[side], -1, (1 - place) * length)):
        near = (distance < cut * (1 - 1e-9)) & (outlines.exterior_angles[corner] > _STRAIGHT)
        at, way, step = corner[near], sign * outlines.directions[side[near]], distance[near] * (ARC_EDGES / cut)
        before = np.minimum(np.floor(step + 1e-9), ARC_EDGES - 1)
        radius, centre = _circles(outlines, at, cut)
        one, two = (
            _on_circle(outlines.corners[at] + way * ((before + end) * (cut / ARC_EDGES))[:, None], centre, radius)
            for end in (0, 1)
        )
        share = (step - before)[:, None]
        rounded[near] = (1 - share) * one + share * two
    return rounded


def arcs_along(
    outer: Array, outlines: Outlines, side: Index, place: Array, cut: float, ahead: Index
) -> tuple[Index, Arcs]:
    """Return the nodes from which the outer wall goes on along an arc, and these arcs; see `round_corners`.

    Nodes stand at `outer`, and each is followed by the node `ahead`.
    """
    length = outlines.lengths[side]
    end = np.where(side[ahead] == side, place[ahead], 1.0)
    found, parts = [], []
    for corner, sign, one, two in ((side, 1, place, end), (outlines.ahead[side], -1, 1 - place, 1 - end)):
        is_round = outlines.exterior_angles[corner] > _STRAIGHT
        node = np.flatnonzero((np.maximum(one, two) * length < cut * (1 + 1e-9)) & is_round)
        at = corner[node]
        radius, centre = _circles(outlines, at, cut)
        found.append(node)
        parts.append({
            "sharp": outlines.corners[at], "centre": centre, "radius": radius,
            "way": sign * outlines.directions[side[node]],
            "distance": np.column_stack([one, two])[node] * length[node, None],
            "chord": np.stack([outer[node], outer[ahead[node]]], axis=1),
        })  # fmt: skip
    return np.concatenate(found), Arcs(**{name: np.concatenate([part[name] for part in parts]) for name in parts[0]})


def _on_circle(place: Array, centre: Array, radius: Array) -> Array:
    """Return the points of circles that lie from their centres towards places, all of shape (..., 2) but the radii."""
    ray = place - centre
    return np.asarray(centre + ray * (radius / np.linalg.norm(ray, axis=-1))[..., None])


def _circles(outlines: Outlines, corner: Index, cut: float) -> tuple[Array, Array]:
    """Return radii, (n,), and centres, (n, 2), of the arcs that round corners [length]."""
    radius = cut / np.tan(outlines.exterior_angles[corner] / 2)
    return radius, outlines.corners[corner] + radius[:, None] * outlines.bisectors[corner]
