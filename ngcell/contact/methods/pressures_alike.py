"""Pressures whose forces are those of another contact method: where multipliers begin.

A penalty holds tissues at corners, in a few points, with pressures that are too peaked to be sampled: a stiff one's,
taken as they are, made forces several times as large. So pressures are fitted to the forces on the nodes, by least
squares among those that are not negative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.methods.protocol import ContactSet

Array = NDArray[np.float64]

#: Steps of the projected gradient method; it only has to begin near what updates lead to.
_STEPS = 300


def nodal_forces(contact: ContactSet, positions: Array) -> Array:
    """Return the contact forces on the nodes along increasing gaps [stress * length**(dimension - 1)]."""
    _, slopes = contact.kinematics.slopes(positions)
    jacobian = contact.kinematics.jacobian(slopes, positions.shape[1])
    return np.asarray(jacobian.T @ contact.contact_forces(positions))


def pressures_alike(pulled: sparse.csc_array, forces: Array) -> Array:
    """Return pressures >= 0 whose nodal forces differ least from those that are given.

    It takes accelerated projected gradients (Beck and Teboulle 2009, doi:10.1137/080716542), scaled by row sums of the
    normal equations, which bound their matrix.

    Parameters
    ----------
    pulled : csc_array, shape (unknowns, m)
        Forces on the nodes of each pressure of 1.
    forces : array of float, shape (unknowns,)
        The forces to be met.
    """
    matrix, right = (pulled.T @ pulled).tocsr(), pulled.T @ forces
    bound = np.asarray(abs(matrix).sum(1), dtype=float)
    scale = np.divide(1.0, bound, out=np.zeros_like(bound), where=bound > 0)
    found = ahead = np.zeros_like(right)
    pace = 1.0
    for _ in range(_STEPS):
        before, found = found, np.maximum(ahead - scale * (matrix @ ahead - right), 0)
        pace, last = (1 + (1 + 4 * pace**2) ** 0.5) / 2, pace
        ahead = found + (last - 1) / pace * (found - before)
    return np.asarray(found)
