"""The numbers of the solver and of contact that no case names, as one record that is handed down."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ngcell.contact.options import ContactOptions
from ngcell.solve.options import SolverOptions

#: Stiffness of penalty terms, in layers of elements behind the wall, at an accuracy.
_STIFF, _ASKED = 100.0, 0.01
#: Length by which conditions that multipliers enforce may be missed, as a share of the accuracy. At 1e-6 the mortar
#: method saves a round of updates, but forces of fluids, which are stiff, are left out of balance.
_MISSED = 1e-8


@dataclass(frozen=True)
class Options:
    """Numbers on which results hardly depend, but for the branch that is found (`python -m tools.studies constants`).

    Attributes
    ----------
    solver : SolverOptions
        Those of minimisation, continuation and load stepping.
    contact : ContactOptions
        Those of contact.
    """

    solver: SolverOptions = field(default_factory=SolverOptions)
    contact: ContactOptions = field(default_factory=ContactOptions)

    def for_accuracy(self, accuracy: float) -> Options:
        """Return the numbers for meshes on which errors are to be small: contact that is as stiff as they ask for.

        What a penalty costs in energy falls with the root of its stiffness, where corners bear; at 100 times the layer
        behind the wall it is a quarter of a percent in a sheared tissue.
        """
        # Contact costs twice what its penalty terms store: a quarter of the accuracy, at most.
        stored = min(self.contact.stored, accuracy / 8)
        multiple = min(_STIFF * (_ASKED / accuracy) ** 2, self.contact.most_multiple)
        stiff = replace(self.contact, penalty_multiple=max(self.contact.penalty_multiple, multiple), stored=stored)
        path = self.solver.continuation
        ends = replace(path, condition=max(path.condition, min(_MISSED * accuracy, _MISSED)))
        return replace(self, contact=stiff, solver=replace(self.solver, continuation=ends))

    def for_path(self) -> Options:
        """Return the numbers for a mesh on which the load path is followed and nothing is reported: no multipliers."""
        solver = replace(self.solver, continuation=replace(self.solver.continuation, only_leads=True))
        return replace(self, solver=solver, contact=replace(self.contact, only_leads=True))
