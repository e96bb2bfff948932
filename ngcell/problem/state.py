"""What a problem knows of a place: its energy and configuration, and the second-order model about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.term import Configuration, OneSided

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class State:
    """A place.

    Attributes
    ----------
    displacement : array of float, shape (unknowns,)
        The unknowns that are solved for [length].
    energy : float
        Sum of all terms [stress * length**dimension]; NaN where an element is inverted.
    at : Configuration
        Where all bodies are, and the active sets that terms have found there.
    """

    displacement: Array
    energy: float
    at: Configuration

    @property
    def positions(self) -> Array:
        """Deformed positions as unknowns, shape (dimension, size) [length]."""
        return self.at.positions


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Second-order model of the energy about a state, with one-sided constraints kept apart.

    ``E(u + d) ~ E + gradient d + d K d / 2 + sum_i penalty_i (min(0, gap_i + jacobian_i d)^2 - min(0, gap_i)^2) / 2``

    Attributes
    ----------
    gradient : array of float, shape (unknowns,)
        Gradient without that of constraints.
    stiffness : array of float
        K without `curvature`, on the lower pattern of the problem.
    curvature : coo_array or None
        The part of K whose pattern moves: closed contacts, bonds.
    constraints : OneSided
        The constraints.
    """

    gradient: Array
    stiffness: Array
    curvature: sparse.coo_array | None
    constraints: OneSided

    @property
    def gap(self) -> Array:
        """Gaps of the constraints [length]."""
        return self.constraints.gap

    @property
    def jacobian(self) -> sparse.csr_array:
        """Their derivatives by the unknowns."""
        return self.constraints.jacobian

    @property
    def penalty(self) -> Array:
        """Their stiffness."""
        return self.constraints.penalty

    @property
    def lowered(self) -> Array | None:
        """By how much multipliers lower their gaps [length]; NaN where a constraint has none, None where no one has."""
        return self.constraints.lowered

    @property
    def keys(self) -> Index:
        """What tells the constraints of different states apart."""
        return self.constraints.keys
