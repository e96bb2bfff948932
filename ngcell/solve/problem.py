"""What the solver asks of a problem, and nothing more."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class State(Protocol):
    """A point with its energy; whatever else the problem needs to know about it."""

    @property
    def displacement(self) -> Array:
        """The unknowns, shape (unknowns,)."""

    @property
    def energy(self) -> float:
        """The energy, NaN where it is not defined."""


class Linearisation(Protocol):
    """Second-order model about a state; see `ngcell.contact.state.Linearisation`."""

    gradient: Array
    stiffness: Array
    curvature: sparse.coo_array | None
    gap: Array
    jacobian: sparse.csr_array
    penalty: Array
    keys: Index


class Problem(Protocol):
    """An energy of many unknowns with one-sided penalty terms."""

    free: NDArray[np.bool_]

    @property
    def dimension(self) -> int:
        """Space dimension."""

    @property
    def part(self) -> Index:
        """Body of each unknown: what unknowns of different bodies have in common are penalty terms and ties only."""

    @property
    def mass(self) -> sparse.csr_array:
        """Weight of displacements, shape (unknowns, unknowns)."""

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `Linearisation.stiffness` fills."""

    def at(self, displacement: Array) -> State:
        """Return the state with this displacement."""

    def move(self, displacement: Array, step: Array) -> Array:
        """Return ``displacement + step``, up to terms of second order in the step."""

    def gradient(self, state: State) -> Array:
        """Return the gradient of the energy, shape (unknowns,)."""

    def linearise(self, state: State) -> Linearisation:
        """Return the model about a state."""

    def gaps(self, state: State) -> tuple[Index, Array]:
        """Return the keys of the penalty terms of a state, increasing, and their gaps."""

    def couplings(self, state: State, margin: float) -> tuple[Index, Index]:
        """Return the entries that penalty terms could fill while nothing moves by more than half of `margin`."""

    def follow(self, other: Problem, state: State) -> None:
        """Start from what another problem knows at an equilibrium of its own, and forget what was updated before."""

    def update_multipliers(self, state: State) -> tuple[float, float]:
        """Update the multipliers from an equilibrium; return the gap [length] by which it misses conditions that the energy only
        approaches, and the energy that stands for what is missed; zeros where there are none."""

    def increase_penalty(self) -> None:
        """Make `update_multipliers` miss less each time, at the price of an energy that is harder to minimise."""
