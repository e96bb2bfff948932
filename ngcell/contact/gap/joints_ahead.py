"""Concave joints that points of a wall have been pressed over: how far ahead they are, as one-sided penalty terms.

A corner that presses on a wall bends it most where two of its edges meet, and comes to rest in the notch that it makes
there. Behind the joint, in the sector between the normals of both edges, the closest point is the joint, and holds the
point by the whole stiffness of its penalty term. That sector is narrower than the overlap. A model of the energy from a
place before it does not see it: steps go on to the other edge, and back. So, of a point whose step went over a joint,
the distance that its closest point is from the joint counts as a gap, of the stiffness of the point's own: that is the
energy in the sector to second order. The energy has no such term, and models only where steps have failed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.surface.edges import EdgeSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def joints_ahead(
    walls: EdgeSurface, before: GapKinematics, place: Index, after: GapKinematics, positions: Array, moved: Array
) -> tuple[Index, Array, Array, sparse.csr_array]:
    """Return which pairs a step has pressed over a concave joint, the square of the derivative of their gaps by the
    distance, how far ahead the joint is [length], and its derivatives.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    before, after : GapKinematics
        The pairs before and after the step.
    place : array of int, shape (pairs before,)
        Which pair after the step has the same point and part; -1 if none has.
    positions, moved : array of float, shape (2, scalar unknowns)
        Where bodies were, and are.
    """
    old, new = before.pairs, after.pairs
    vertices, angle = walls.vertices, walls.exterior_angle_at(walls.nodes(moved))
    edge, other = old.secondary, new.secondary[place]
    pressed = (place >= 0) & ~old.at_end & (after.gaps(moved)[place] < 0)
    end = np.full(len(old), -1)
    for number in range(2):
        joint = vertices[edge, number]
        is_over = (other != edge) & (vertices[other] == joint[:, None]).any(1)
        is_behind = (other == edge) & new.at_end[place] & (new.secondary_xi[place] == number)
        end[pressed & (is_over | is_behind) & (angle[edge, number] < 0)] = number
    chosen = np.flatnonzero(end >= 0)
    towards = np.where(end[chosen] == 1, 1.0, -1.0)
    a, t = (vector[chosen] for vector in before.vectors(positions))
    speed = np.linalg.norm(t, axis=1)
    to_end = np.where(end[chosen] == 1, 1 - old.secondary_xi[chosen], old.secondary_xi[chosen])
    slopes = np.zeros((len(old), 4))
    slopes[chosen] = -(towards / speed)[:, None] * np.concatenate([t, a], axis=1)
    factor = (before.slopes(positions)[1][chosen, :2] ** 2).sum(1)
    return chosen, factor, to_end * speed, before.jacobian(slopes, positions.shape[1])[chosen]
