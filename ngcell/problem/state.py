"""What the assembly knows of a place: its energy and contact pairs, and the second-order model about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.methods.protocol import ContactSet

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class State:
    """A displacement, its energy and, in contact, its contact pairs.

    Attributes
    ----------
    displacement : array of float, shape (unknowns,)
        The displacement [length].
    energy : float
        Energy of bulk, contact and bonds [stress * length**dimension]; NaN where an element is inverted.
    positions : array of float, shape (dimension, size)
        Deformed positions as unknowns [length]; not to be written to.
    contact : ContactSet or None
        The contact pairs at this displacement.
    """

    displacement: Array
    energy: float
    positions: Array
    contact: ContactSet | None = None


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Second-order model of the energy about a state, with the penalty terms of near walls kept apart.

    ``E(u + d) ~ E + gradient d + d K d / 2 + sum_i stiffness_i (min(0, gap_i + jacobian_i d)^2 - min(0, gap_i)^2) / 2``

    Attributes
    ----------
    gradient : array of float, shape (unknowns,)
        Gradient without the penalty terms' part.
    stiffness : array of float
        K without `curvature`, on the lower pattern of the assembly.
    curvature : coo_array or None
        Geometric part of closed contacts, and the tangent of bonds.
    gap, jacobian, penalty term : array, csr_array, array
        The penalty terms: gaps, their derivatives by the unknowns, and stiffness.
    keys : array of int
        What tells the penalty terms of different states apart.
    """

    gradient: Array
    stiffness: Array
    curvature: sparse.coo_array | None
    gap: Array
    jacobian: sparse.csr_array
    penalty: Array
    keys: Index
