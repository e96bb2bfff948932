"""A problem: the sum of terms over the unknowns of a scene, as the solver asks for it.

The sum knows no term by name and no load path. It adds up values, gradients and tangents, keeps one-sided constraints
apart for the solver, and passes on to all terms what concerns their history and their multipliers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.drive import Drive
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.symbolic import SymbolicTerm
from ngcell.mechanics.symbolic_sum import fused, parts_of
from ngcell.mechanics.term import NO_ENTRIES, Configuration, OneSided, Role, Term
from ngcell.problem.of_components import OfComponents
from ngcell.problem.reports import deepest_overlap
from ngcell.problem.rotation import finite_rotation_update
from ngcell.problem.state import Linearisation, State
from ngcell.problem.stored import stored_by
from ngcell.problem.sums import between_components, folded, joined, keyed, sorted_gaps, together, total, whole_gradient
from ngcell.problem.tie import Tie, solid_of_body
from ngcell.problem.unknowns import OwnUnknowns, TiedUnknowns, UnknownMap

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Problem:
    """Bodies and all that acts in and between them.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    terms : sequence of Term
        What the energy consists of. Problems that share symbolic terms share their form if these were fused before.
    fixed : array of bool, shape (dimension, size)
        Unknowns with prescribed displacement.
    tie, length : Tie, float, optional
        Ties between walls, without which bodies move by themselves; half of the diameter of a body [length].
    """

    def __init__(
        self, space: DisplacementSpace, terms: Sequence[Term], fixed: Mask, *, tie: Tie | None = None, length: float = 0
    ) -> None:
        self.space, self._sum = space, fused(terms)
        self.terms: tuple[Term, ...] = parts_of(self._sum)
        self.fixed, self._length = fixed.ravel(), length or space.bodies.length
        self.unknowns: UnknownMap = OwnUnknowns(self.fixed) if tie is None else TiedUnknowns(tie, space, self.fixed)
        self.free, self._solid_of_body = self.unknowns.free, solid_of_body(space, tie)

    @property
    def dimension(self) -> int:
        """Space dimension."""
        return self.space.dimension

    @property
    def part(self) -> Index:
        """Body of each unknown, shape (unknowns,)."""
        return np.tile(self.space.body_of_unknown, self.dimension)

    @property
    def solid(self) -> Index:
        """Solid of each unknown, shape (unknowns,): bodies that are tied to each other are one."""
        return np.asarray(self._solid_of_body[self.part])

    @cached_property
    def metric(self) -> OfComponents:
        """Metric of displacements: their squares, and those of gradients times the squared diameter of a body."""
        return OfComponents(self.space.metric_of_one(2 * self._length), self.dimension, self.unknowns)

    @cached_property
    def mass(self) -> OfComponents:
        """Mass matrix, shape (unknowns, unknowns); the metric of curvatures."""
        return OfComponents(self.space.scalar_mass, self.dimension, self.unknowns)

    def configuration(self, displacement: Array) -> Configuration:
        """Return where all bodies are with this displacement."""
        return self.space.configuration(self.unknowns.expand(displacement))

    def expand(self, displacement: Array) -> Array:
        """Return the displacement of all unknowns, those of tied walls included."""
        return self.unknowns.expand(displacement)

    def at(self, displacement: Array) -> State:
        """Return the state with this displacement."""
        at, energy = self.configuration(displacement), 0.0
        for term in self._sum:
            energy += term.value(at)
            if not np.isfinite(energy):
                break  # elements are inverted: pairs that would be found there mean nothing
        return State(displacement, energy, at)

    def move(self, displacement: Array, step: Array) -> Array:
        """Return the displacement after a step in which bodies that float rotate instead of stretching.

        Added up, a step that rotates a body also blows it up, by the square of the angle; a cell that rolls in its
        place would pay for that with the stiffness of its walls, and only tiny steps would lower the energy. So the
        mean rotation of each body without support is applied as a rotation. To first order this is the step.
        """
        moved = displacement + step
        if not self.unknowns.lets_bodies_part or len(self._supported) == self.space.body_count:
            return moved
        at, by = self.configuration(displacement).positions, step.reshape(self.dimension, -1)
        return moved + finite_rotation_update(at, by, self.space.one, self.space.body_of_unknown, self._supported)

    @cached_property
    def _supported(self) -> Index:
        """Bodies with a support."""
        supported = self.fixed.reshape(self.dimension, -1).any(0)
        return np.unique(self.space.body_of_unknown[supported])

    def gradient(self, state: State) -> Array:
        """Return the gradient of the whole energy, shape (unknowns,)."""
        return self.unknowns.gather(total(whole_gradient(term, state.at) for term in self._sum))

    def gradient_of_constraints(self, state: State) -> Array:
        """Return the part of it that is due to one-sided constraints."""
        return self.unknowns.gather(self._constraints(state.at).gradient)

    def force(self, at: Configuration, role: Role) -> Array:
        """Return the sum of the gradients of all terms with a role, on all unknowns, shape (unknowns,)."""
        found = [whole_gradient(term, at) for term in self.terms if term.role is role]
        return total(found) if found else np.zeros_like(at.displacement)

    def linearise(self, state: State) -> Linearisation:
        """Return the second-order model about a state."""
        at = state.at
        gradient = self.unknowns.gather(total(term.gradient(at) for term in self._sum))
        tangents = [tangent for term in self._sum if len(tangent := term.tangent(at))]
        stiffness = joined(*tangents) if tangents else np.zeros(0)
        if self._factors is not None:
            stiffness = stiffness * self._factors
        curvature = folded(self.unknowns, (term.curvature(at) for term in self._sum))
        return Linearisation(gradient, stiffness, curvature, self._folded(self._constraints(at)))

    def convex_curvature(self, state: State) -> sparse.coo_array | None:
        """Return a convex part of the curvature of constraints."""
        return folded(self.unknowns, (term.convex_curvature(state.at) for term in self._sum))

    def _folded(self, constraints: OneSided) -> OneSided:
        """Return constraints with derivatives by the unknowns that are solved for."""
        return replace(constraints, jacobian=self.unknowns.fold_columns(constraints.jacobian))

    def _constraints(self, at: Configuration) -> OneSided:
        """Return the constraints of all terms; keys of different terms differ."""
        return together(keyed((term.constraints(at) for term in self._sum), len(self._sum)), at)

    def kinks(self, state: State, after: State) -> OneSided | None:
        """Return constraints that a model needs for steps over kinks, as that to another state; None if none."""
        found = keyed((term.kinks(state.at, after.at) for term in self._sum), len(self._sum))
        return self._folded(together(found, state.at)) if found else None

    def gaps(self, state: State) -> tuple[Index, Array]:
        """Return the keys of the constraints of a state, increasing, and their gaps."""
        return sorted_gaps([term.gaps(state.at) for term in self._sum])

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `Linearisation.stiffness` fills, with repetitions."""
        return self._folded_pattern()[:2]

    @cached_property
    def _factors(self) -> NDArray[Any] | None:
        """The factors of entries that stand on the pattern several times; None where all are 1."""
        return self._folded_pattern()[2]

    def _folded_pattern(self) -> tuple[Index, Index, NDArray[Any] | None]:
        parts = [pattern for term in self._sum if len((pattern := term.pattern)[0])] or [NO_ENTRIES]
        row, column = zip(*parts, strict=True)
        return self.unknowns.fold(joined(*row), joined(*column))

    def couplings(self, state: State, margin: float) -> tuple[Index, Index]:
        """Return entries of the lower triangle that constraints could fill while no move exceeds half of `margin`."""
        parts = [term.couplings(state.at, margin) for term in self._sum]
        row, column = (np.concatenate(part) for part in zip(*parts, strict=True))
        return self.unknowns.fold(*between_components(row, column, self.space.size, self.dimension))[:2]

    def unstored(self, at: Configuration) -> float:
        """Return what the energy holds without its being stored in bodies."""
        return sum(term.unstored(at) for term in self._sum)

    def magnitude(self, state: State) -> float:
        """Return the larger of the energy and of the part of it that is stored in bodies."""
        return max(abs(state.energy), abs(state.energy - self.unstored(state.at)))

    def resultants(self, nodal: Array) -> Array:
        """Return the sum of nodal forces over each body, shape (bodies, dimension)."""
        return self.space.resultants(nodal)

    def overlap_work(self, at: Configuration) -> float:
        """Return forces times overlaps of all terms: by no more than that, rigid contact would change energies."""
        return sum(term.overlap_work(at) for term in self.terms)

    def overlap(self, state: State) -> float:
        """Return the deepest overlap of bodies over the thickness of the thinner one."""
        return deepest_overlap(self.terms, state.at, self.space.bodies.thickness_of_body) or 0.0

    def drives(self, displacement: Array, load_factor: float) -> tuple[Drive, ...]:
        """Return how driven terms take in work, one after the other."""
        at = self.configuration(displacement)
        found = (term.drive(at, load_factor) for term in self.terms)
        return tuple(drive for drive in found if drive is not None)

    def apply(self, load_factor: float) -> None:
        """Let all terms act as at this load factor."""
        for term in self.terms:
            term.apply(load_factor)

    def start_from(self, before: Problem, state: State) -> None:
        """Start from what the problem of the continuation stage before knows at its equilibrium."""
        for mine, theirs in zip(self.terms, before.terms, strict=True):
            mine.start_from(theirs, state.at)

    def refine(self, coarse: Problem, state: State) -> None:
        """Take over what the problem on a coarser mesh knows at an equilibrium of its own."""
        for mine, theirs in zip(self.terms, coarse.terms, strict=True):
            mine.refine(theirs, state.at)

    def update_multipliers(self, state: State) -> tuple[float, float]:
        """Let terms update their multipliers; return the largest length that conditions miss, and its energy."""
        stored = StoredEnergy(lambda: stored_by(self.terms, state.at, self.space.body_count))
        # The last terms first: contact is judged by the stored energy, which fluids change when they update.
        found = [term.update_multipliers(state.at, stored) for term in reversed(self.terms)]
        return max(missed for missed, _ in found), sum(energy for _, energy in found)

    def take_finer_rule(self, state: State) -> bool:
        """Let terms integrate by finer rules where theirs miss too much; tell whether any does."""
        return any([term.take_finer_rule(state.at) for term in self.terms if isinstance(term, SymbolicTerm)])

    def folded(self, state: State) -> Mask:
        """Return the solids that store no finite energy, since something in them is turned inside out."""
        is_folded = ~np.isfinite(stored_by(self.terms, state.at, self.space.body_count)[0])
        return np.bincount(self._solid_of_body, weights=is_folded) > 0

    @property
    def has_multipliers(self) -> bool:
        """Whether pressures are unknowns of their own, whose multipliers lower gaps."""
        return any(getattr(term, "has_multipliers", False) for term in self.terms)

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Let terms take multipliers that are foreseen, by `Linearisation.keys`, and by how much they lower gaps."""
        number = keys % len(self._sum)
        for of in np.unique(number).tolist():
            self._sum[of].take_multipliers(keys[number == of] // len(self._sum), lowered[number == of])

    def note_kinks(self, state: State) -> bool:
        """Let terms change their energy where its kinks would hold up steps from here; tell whether any has."""
        return any([term.note_kinks(state.at) for term in self.terms])

    def increase_penalty(self) -> None:
        """Let multipliers be updated in larger steps."""
        for term in self.terms:
            term.increase_penalty()

    @property
    def has_history(self) -> bool:
        """Whether any term remembers accepted steps."""
        return any(term.has_history for term in self.terms)

    def accept(self, displacement: Array) -> None:
        """Let terms remember an accepted state."""
        at = self.configuration(displacement)
        for term in self.terms:
            term.accept(at)

    def release(self) -> None:
        """Give memory back that is filled anew when it is needed."""
        for term in self._sum:
            if isinstance(term, SymbolicTerm):
                term.release()

    def reset(self) -> None:
        """Let terms forget all accepted states."""
        for term in self.terms:
            term.reset()

    def begin_path(self) -> None:
        """Let terms begin a load path whose steps follow each other."""
        for term in self.terms:
            term.begin_path()

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what terms remember, by name."""
        return {name: values for term in self.terms for name, values in term.memory().items()}

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Let terms take up again what `memory` returned."""
        for term in self.terms:
            term.recall(memory)
