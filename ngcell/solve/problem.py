"""What the solver asks of a problem, and nothing more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class SymmetricOperator(Protocol):
    """A symmetric matrix, such as `scipy.sparse.csr_array`, that may be held in a shorter form."""

    def __matmul__(self, vector: Array, /) -> Array:
        """Return the product with a vector."""

    def tocsr(self) -> sparse.csr_array:
        """Return all of its entries."""


class State(Protocol):
    """A point with its energy; whatever else the problem needs to know about it."""

    @property
    def displacement(self) -> Array:
        """The unknowns, shape (unknowns,)."""

    @property
    def energy(self) -> float:
        """The energy, NaN where it is not defined."""


class Constraints(Protocol):
    """One-sided quadratic constraints."""

    @property
    def gap(self) -> Array:
        """Gaps, shape (n,)."""

    @property
    def jacobian(self) -> sparse.csr_array:
        """Their derivatives, shape (n, unknowns)."""

    @property
    def penalty(self) -> Array:
        """Their stiffness, shape (n,)."""

    @property
    def keys(self) -> Index:
        """What tells the constraints of different states apart."""


class Linearisation(Constraints, Protocol):
    """Second-order model about a state; see `ngcell.problem.state.Linearisation`."""

    @property
    def gradient(self) -> Array:
        """Gradient without that of one-sided constraints, shape (unknowns,)."""

    @property
    def stiffness(self) -> Array:
        """Second derivative on the lower pattern of the problem, without `curvature`."""

    @property
    def curvature(self) -> sparse.coo_array | None:
        """The part of the second derivative whose pattern moves."""

    @property
    def lowered(self) -> Array | None:
        """By how much multipliers lower the gaps [length]; NaN where a constraint has none, None where no one has."""


class Driven(Protocol):
    """How a load takes in work."""

    @property
    def share(self) -> float:
        """Share of the full load that acts."""

    @property
    def potential(self) -> float:
        """Potential at the full load."""


class Problem(Protocol):
    """An energy of many unknowns with one-sided constraints."""

    @property
    def free(self) -> NDArray[np.bool_]:
        """Unknowns that are solved for, shape (unknowns,)."""

    @property
    def dimension(self) -> int:
        """Space dimension."""

    @property
    def part(self) -> Index:
        """Body of each unknown: what unknowns of different bodies have in common are constraints and ties only."""

    @property
    def solid(self) -> Index:
        """Solid of each unknown: what those of different solids have in common are constraints only."""

    @property
    def metric(self) -> SymmetricOperator:
        """Metric of displacements, shape (unknowns, unknowns): the proximal term and damping are multiples of it."""

    @property
    def mass(self) -> SymmetricOperator:
        """Mass matrix, shape (unknowns, unknowns): the metric of curvatures."""

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `Linearisation.stiffness` fills."""

    def at(self, displacement: Array) -> State:
        """Return the state with this displacement."""

    def release(self) -> None:
        """Give memory back that is filled anew when it is needed."""

    def overlap(self, state: Any) -> float:
        """Return the deepest overlap of bodies over the thickness of the thinner one."""

    def expand(self, displacement: Array) -> Array:
        """Return the displacement of all unknowns, those that follow others included."""

    def move(self, displacement: Array, step: Array) -> Array:
        """Return ``displacement + step``, up to terms of second order in the step."""

    def magnitude(self, state: Any) -> float:
        """Return the energy beside which others are judged: the larger of that of a state and of what is stored there.

        Loads may take as much away as bodies store; the accuracy that is asked for is that of what they store.
        """

    def gradient(self, state: Any) -> Array:
        """Return the gradient of the energy, shape (unknowns,)."""

    def gradient_of_constraints(self, state: Any) -> Array:
        """Return the part of the gradient that is due to one-sided constraints, shape (unknowns,)."""

    def convex_curvature(self, state: Any) -> sparse.coo_array | None:
        """Return a convex part of `Linearisation.curvature`; None if there is none."""

    def linearise(self, state: Any) -> Linearisation:
        """Return the model about a state."""

    def gaps(self, state: Any) -> tuple[Index, Array]:
        """Return the keys of the constraints of a state, increasing, and their gaps."""

    def couplings(self, state: Any, margin: float) -> tuple[Index, Index]:
        """Return the entries that constraints could fill while nothing moves by more than half of `margin`."""

    def apply(self, load_factor: float) -> None:
        """Let loads act as at this load factor."""

    def drives(self, displacement: Array, load_factor: float) -> Sequence[Driven]:
        """Return how loads take in work."""

    def start_from(self, before: Any, state: Any) -> None:
        """Start from what the problem of the continuation stage before knows at an equilibrium of its own."""

    def resultants(self, nodal: Array) -> Array:
        """Return the sum of nodal forces over each body, shape (bodies, dimension)."""

    def folded(self, state: Any) -> NDArray[np.bool_]:
        """Return the solids whose energy is not finite, shape (solids,)."""

    def update_multipliers(self, state: Any) -> tuple[float, float]:
        """Update multipliers at an equilibrium; return the gap [length] by which it misses conditions that the
        energy only approaches, and the energy that stands for what is missed; zeros where there are none."""

    def take_finer_rule(self, state: Any) -> bool:
        """Integrate by finer rules from now on where those of this equilibrium miss too much; tell whether any does."""

    @property
    def has_multipliers(self) -> bool:
        """Whether multipliers lower gaps."""

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Take multipliers that are foreseen, by how much they lower the gaps of constraints with these keys."""

    def kinks(self, state: Any, after: Any) -> Constraints | None:
        """Return constraints that a model needs for steps over kinks, as that to another state; None if none."""

    def note_kinks(self, state: Any) -> bool:
        """Change the energy of other places where its kinks would hold up steps from here, and tell whether it has."""

    def increase_penalty(self) -> None:
        """Make updates miss less each time, at the price of an energy that is harder to minimise."""

    @property
    def has_history(self) -> bool:
        """Whether the problem remembers accepted steps."""

    def accept(self, displacement: Array) -> None:
        """Keep what this accepted state leaves for good."""

    def reset(self) -> None:
        """Forget all accepted steps."""

    def begin_path(self) -> None:
        """Begin a load path whose steps follow each other."""

    def memory(self) -> Mapping[str, NDArray[Any]]:
        """Return what is remembered of the load path, by name."""

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Take up again what `memory` returned."""
