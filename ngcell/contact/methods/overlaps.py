"""Overlaps that penalty terms leave, body by body: what is judged where penalty terms adapt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.near import components

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Points that lie in another body.

    Attributes
    ----------
    bodies : array of int, shape (n, 2)
        The two bodies.
    depth : array of float, shape (n,)
        How deep each point lies in the other body [length], > 0.
    share : array of float, shape (n,)
        The depth over the thickness of the thinner of the two.
    energy : array of float, shape (n,)
        What its penalty term stores [energy].
    """

    bodies: Index
    depth: Array
    share: Array
    energy: Array

    @property
    def deepest(self) -> float:
        """Largest depth [length]; 0 if nothing overlaps."""
        return float(self.depth.max(initial=0.0))

    @property
    def largest_share(self) -> float:
        """Largest depth over thickness; 0 if nothing overlaps."""
        return float(self.share.max(initial=0.0))

    def within(self, group: Mask) -> Overlaps:
        """Return those between members of a group; `group` has shape (bodies,)."""
        mine = group[self.bodies].all(1)
        return Overlaps(self.bodies[mine], self.depth[mine], self.share[mine], self.energy[mine])

    def groups(self, body_count: int) -> list[Mask]:
        """Return the members of each group of bodies that overlap, directly or by way of others, shape (bodies,)."""
        label = components(body_count, *self.bodies.T)
        return [label == number for number in np.unique(label[self.bodies])]


def overlaps(walls: Surface, pairs: ContactPairs, gaps: Array, force: Array | None = None) -> Overlaps:
    """Return the overlaps of contact pairs with gaps [length] and, by a penalty, forces; both of shape (pairs,)."""
    inside = np.flatnonzero(gaps < 0)
    bodies = walls.body[np.column_stack([pairs.primary, pairs.secondary])[inside]]
    depth = -gaps[inside]
    energy = np.zeros_like(depth) if force is None else force[inside] * depth / 2
    return Overlaps(bodies, depth, depth / walls.thickness[bodies].min(1), energy)
