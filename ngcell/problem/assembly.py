"""Bodies in contact, or tied to one tied solid: the energy that the solver minimises.

The assembly sums its terms and knows no load path. Unknowns of a tied assembly keep their numbers: slaves follow
their masters (``u = sign u[master]``), and are not free.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.methods.protocol import ContactMethod
from ngcell.mechanics.bulk import BulkEnergy
from ngcell.mechanics.space import DisplacementSpace, csr_matrix
from ngcell.problem.rotation import finite_rotation_update
from ngcell.problem.state import Linearisation, State
from ngcell.problem.tie import Tie

if TYPE_CHECKING:
    from ngcell.contact.cohesion.bonds import Bonds
    from ngcell.mechanics.fluid import LumenFluids

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Assembly:
    """Bodies with a stored energy, in contact or tied.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    bulk : BulkEnergy
        Stored energy of the bodies.
    fixed : array of bool, shape (dimension, size)
        Unknowns with prescribed displacement.
    contact : ContactMethod, optional
        Contact between walls; without it walls pass through each other.
    tie : Tie, optional
        Ties between walls.
    fluid : LumenFluids, optional
        Fluids in the lumens; by default there are none.
    bonds : Bonds, optional
        Cohesion between walls; not together with a tie.
    """

    def __init__(
        self,
        space: DisplacementSpace,
        bulk: BulkEnergy,
        fixed: NDArray[np.bool_],
        *,
        contact: ContactMethod | None = None,
        tie: Tie | None = None,
        fluid: LumenFluids | None = None,
        bonds: Bonds | None = None,
    ) -> None:
        self.space = space
        self.bulk = bulk
        self.contact = contact
        self.fluid = fluid
        self.bonds = bonds
        self._tie = _by_component(tie, space) if tie is not None else None
        self.fixed = fixed.ravel()
        self.free = ~self.fixed
        if self._tie is not None:
            master, _ = self._tie
            slave = master != np.arange(space.unknowns)
            held = np.zeros(space.unknowns, dtype=bool)
            np.logical_or.at(held, master, fixed.ravel())
            self.free = ~held & ~slave

    @property
    def dimension(self) -> int:
        """Space dimension."""
        return self.space.dimension

    @property
    def part(self) -> Index:
        """Body of each unknown, shape (unknowns,)."""
        return np.tile(self.space.body_of_unknown, self.space.dimension)

    @cached_property
    def mass(self) -> sparse.csr_array:
        """Mass matrix, shape (unknowns, unknowns); weighs displacements in the solver's proximal term."""
        mass = sparse.block_diag([self.space.scalar_mass] * self.space.dimension, format="csr")
        if self._tie is None:
            return mass
        master, sign = self._tie
        spread = sparse.csr_array((sign, (np.arange(len(sign)), master)), shape=mass.shape)
        return (spread.T @ mass @ spread).tocsr()

    def at(self, displacement: Array) -> State:
        """Return the state with this displacement."""
        full = self.expand(displacement)
        energy = self.bulk.energy(full)
        if self.fluid is not None:
            energy += self.fluid.energy(full)
        contact, positions = None, self.positions(full)
        if self.contact is not None and np.isfinite(energy):
            contact = self.contact.pair(positions)
            energy += contact.energy(positions)
        if self.bonds is not None:
            energy += self.bonds.energy(positions)
        return State(displacement, energy, positions, contact)

    def move(self, displacement: Array, step: Array) -> Array:
        """Return the displacement after a step in which bodies that float turn instead of stretching.

        Added up, a step that rotates a body also blows it up, by the square of the angle; a cell that rolls in its
        place would pay for that with the stiffness of its walls, and only tiny steps would lower the energy. So the
        mean rotation of each body without support is applied as a rotation. To first order this is the step.
        """
        moved = displacement + step
        if self._tie is not None or len(self._held) == self.space.bodies.body_count:
            return moved
        at, by = self.positions(displacement), step.reshape(self.space.dimension, -1)
        return moved + finite_rotation_update(at, by, self.space.one, self.space.body_of_unknown, self._held)

    @cached_property
    def _held(self) -> Index:
        """Bodies with a support."""
        supported = self.fixed.reshape(self.space.dimension, -1).any(0)
        return np.unique(self.space.body_of_unknown[supported])

    def expand(self, displacement: Array) -> Array:
        """Return the displacement with slaves following their masters."""
        if self._tie is None:
            return displacement
        master, sign = self._tie
        return sign * displacement[master]

    def potential(self, displacement: Array) -> float:
        """Return what loads, fluids and broken bonds add to the energy of a state without being stored in it."""
        full = self.expand(displacement)
        in_fluids = 0.0 if self.fluid is None else self.fluid.energy(full)
        in_bonds = 0.0 if self.bonds is None else self.bonds.spent(self.positions(full))
        return self.bulk.load_potential(full) + in_fluids + in_bonds

    def gather(self, force: Array) -> Array:
        """Return forces on all unknowns as forces on masters."""
        if self._tie is None:
            return force
        master, sign = self._tie
        return np.bincount(master, weights=sign * force, minlength=len(force))

    def reactions(self, force: Array) -> Array:
        """Return the part of nodal forces that the supports bear, shape (unknowns,); zero elsewhere.

        The force on a tied node is borne by one of its fixed members.
        """
        reaction = np.zeros_like(force)
        member = np.flatnonzero(self.fixed)
        if self._tie is None:
            reaction[member] = force[member]
            return reaction
        master, sign = self._tie
        held, first = np.unique(master[member], return_index=True)
        reaction[member[first]] = sign[member[first]] * self.gather(force)[held]
        return reaction

    def gradient(self, state: State) -> Array:
        """Return the gradient of the whole energy, shape (unknowns,)."""
        full = self.expand(state.displacement)
        force = self._bulk_force(full)
        if state.contact is not None:
            force += self.contact_force(state)
        if self.bonds is not None:
            force += self.bonds.gradient(state.positions)
        return self.gather(force)

    def contact_force(self, state: State) -> Array:
        """Return the contact part of the gradient, shape (unknowns,)."""
        if state.contact is None:
            return np.zeros(self.space.unknowns)
        gap, jacobian, penalty = state.contact.penalty_terms(state.positions)
        return np.asarray(jacobian.T @ (penalty * np.minimum(gap, 0)))

    def linearise(self, state: State) -> Linearisation:
        """Return the second-order model about a state."""
        full = self.expand(state.displacement)
        gradient = self.gather(self._bulk_force(full))
        stiffness = self._lower_stiffness(full)
        positions, bent = state.positions, None
        if self.bonds is not None:
            gradient, bent = gradient + self.bonds.gradient(positions), self.bonds.tangent(positions)
        if state.contact is None:
            nothing = np.zeros(0)
            empty = sparse.csr_array((0, self.space.unknowns))
            return Linearisation(gradient, stiffness, bent, nothing, empty, nothing, nothing.astype(np.int64))
        gap, jacobian, penalty = state.contact.penalty_terms(positions)
        curvature = state.contact.curvature(positions)
        curvature = curvature if bent is None else curvature + bent
        return Linearisation(gradient, stiffness, curvature, gap, jacobian, penalty, state.contact.keys)

    def gaps(self, state: State) -> tuple[Index, Array]:
        """Return the keys of the penalty terms of a state, increasing, and their gaps."""
        if state.contact is None:
            return np.zeros(0, dtype=np.int64), np.zeros(0)
        order = np.argsort(state.contact.keys, kind="stable")
        return state.contact.keys[order], state.contact.gaps(state.positions)[order]

    @cached_property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `Linearisation.stiffness` fills, with repetitions."""
        matrix = csr_matrix(self.bulk.matrix)
        row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
        column = matrix.indices.astype(np.int64)
        self._lower = row >= column
        row, column = row[self._lower], column[self._lower]
        if self.fluid is not None:
            in_fluid = self.fluid.pattern
            row, column = np.concatenate([row, in_fluid[0]]), np.concatenate([column, in_fluid[1]])
        if self._tie is not None:
            master, sign = self._tie
            self._signs = sign[row] * sign[column]
            # An off-diagonal entry that the tie folds onto the diagonal stands for itself and its mirror image.
            folded = (row != column) & (master[row] == master[column])
            self._signs = np.where(folded, 2, 1) * self._signs
            row, column = master[row], master[column]
        return np.maximum(row, column), np.minimum(row, column)

    def couplings(self, state: State, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of the lower triangle that contact and bonds could fill while nothing moves by more
        than half of `margin` [length]."""
        nothing = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
        near = nothing if self.contact is None else self.contact.couplings(state.positions, margin)
        bonded = nothing if self.bonds is None else self.bonds.couplings()
        row, column = (np.concatenate(part) for part in zip(near, bonded, strict=True))
        translations = [axis * self.space.size for axis in range(self.space.dimension)]
        rows = np.concatenate([row + i for i in translations for _ in translations])
        columns = np.concatenate([column + j for _ in translations for j in translations])
        lower = rows >= columns
        return rows[lower], columns[lower]

    def follow(self, other: Assembly, state: State) -> None:
        """Start contact from the pressures of another assembly's equilibrium."""
        if self.contact is not None and other.contact is not None:
            self.contact.follow(other.contact, state.positions)

    def update_multipliers(self, state: State) -> tuple[float, float]:
        """Let contact and fluids be updated from an equilibrium; return the largest length by which they miss conditions,
        and the energy that stands for it."""
        missed, energy = 0.0, 0.0
        if self.contact is not None and state.contact is not None:

            def stored() -> float:
                return state.energy - self.potential(state.displacement)

            missed, energy = self.contact.update_multipliers(state.contact, state.positions, stored)
        if self.fluid is not None:
            off, in_fluid = self.fluid.update_multipliers(self.expand(state.displacement))
            missed, energy = max(missed, off), energy + in_fluid
        return missed, energy

    def advance(self, displacement: Array) -> None:
        """Let bonds remember an accepted state."""
        if self.bonds is not None:
            self.bonds.advance(self.positions(displacement))

    def forget(self) -> None:
        """Let bonds be whole."""
        if self.bonds is not None:
            self.bonds.reset()

    def increase_penalty(self) -> None:
        """Let contact and fluids have a larger penalty."""
        if self.contact is not None:
            self.contact.increase_penalty()
        if self.fluid is not None:
            self.fluid.increase_penalty()

    def _lower_stiffness(self, displacement: Array) -> Array:
        tangent = self.bulk.tangent(displacement)
        _ = self.pattern
        values = np.asarray(tangent.CSR()[0])[self._lower]
        if self.fluid is not None:
            values = np.concatenate([values, self.fluid.tangent(displacement)])
        return values if self._tie is None else values * self._signs

    def _bulk_force(self, displacement: Array) -> Array:
        """Return the gradient of all but the contact energy."""
        force = self.bulk.gradient(displacement)
        return force if self.fluid is None else force + self.fluid.gradient(displacement)

    def positions(self, displacement: Array) -> Array:
        """Return deformed positions as unknowns, shape (dimension, size)."""
        return self.space.rest + displacement.reshape(self.space.dimension, -1)


def _by_component(tie: Tie, space: DisplacementSpace) -> tuple[Index, Array]:
    translations = space.size * np.arange(space.dimension)
    return (tie.master + translations[:, None]).ravel(), np.tile(tie.sign, space.dimension)
