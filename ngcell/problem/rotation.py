"""Finite rotations: steps in which bodies rotate instead of stretching.

A step that rotates a body by a finite angle, added to its positions, also stretches it, by the square of the angle.
What is added here makes the mean rotation of each body that is contained in a step a finite one. The mean rotation is
that which has the same moment as the step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def finite_rotation_update(at: Array, by: Array, one: Array, body: Index, held: Index) -> Array:
    """Return what has to be added to a step for the mean rotation of each body to be finite, shape (unknowns,).

    Parameters
    ----------
    at, by : array of float, shape (dimension, size)
        Deformed positions as unknowns, and the step [length].
    one : array of float, shape (size,)
        The constant 1 as unknowns.
    body : array of int, shape (size,)
        Body of each scalar unknown.
    held : array of int
        Bodies that do not rotate.
    """
    count = int(body.max()) + 1
    weight = np.bincount(body, one, count)
    centre = np.array([np.bincount(body, row * one, count) for row in at]) / weight
    arm = at - centre[:, body] * one
    return _UPDATES[len(at)](arm, by, one, body, held)


def _in_plane(arm: Array, by: Array, one: Array, body: Index, held: Index) -> Array:
    """The angle comes from the moment of the step and the moment of inertia of the nodes."""
    count = int(body.max()) + 1
    moment = np.bincount(body, (arm[0] * by[1] - arm[1] * by[0]) * one, count)
    angle = moment / np.bincount(body, (arm**2).sum(0) * one, count)
    angle[held] = 0
    shrink, correction = (np.cos(angle) - 1)[body], (np.sin(angle) - angle)[body]
    return np.concatenate([shrink * arm[0] - correction * arm[1], correction * arm[0] + shrink * arm[1]])


def _in_three_dimensions(arm: Array, by: Array, one: Array, body: Index, held: Index) -> Array:
    """Rotation vectors come from the moment of the step and the inertia of the nodes; then Rodrigues' formula."""
    count = int(body.max()) + 1
    moment = np.array([np.bincount(body, row * one, count) for row in np.cross(arm, by, axis=0)]).T
    products = np.array([[np.bincount(body, one_row * two_row * one, count) for two_row in arm] for one_row in arm])
    inertia = np.trace(products)[:, None, None] * np.eye(3) - products.transpose(2, 0, 1)
    vector = np.linalg.solve(inertia, moment[..., None])[..., 0]
    vector[held] = 0
    angle = np.linalg.norm(vector, axis=1)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    correction = np.where(small, -(angle**2) / 6, np.sin(safe) / safe - 1)
    shrink = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    once = np.cross(vector[body].T, arm, axis=0)
    twice = np.cross(vector[body].T, once, axis=0)
    return np.asarray((correction[body] * once + shrink[body] * twice).ravel())


#: The update for each number of components that a position has.
_UPDATES = {2: _in_plane, 3: _in_three_dimensions}
