"""Contact of the tied solid around spaces between cells: of the walls that the tie leaves free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.penalty import PenaltyContact, penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.options import ContactOptions
from ngcell.contact.pairing.near import Reach
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import Term
from ngcell.problem.tie import coincident_facets


class ContactAroundSpaces(ContactTerm):
    """Contact of one stage: its penalty terms follow no softer ones, and begin to adapt with each tied state."""

    method: PenaltyContact

    def reset(self) -> None:
        """Forget what the penalty was raised to, and let it adapt again."""
        self.method.restart()


def contact_around_spaces(
    walls: Surface, modulus_of_body: NDArray[np.float64], reach: Reach, options: ContactOptions
) -> tuple[Term, ...]:
    """Return contact between bodies of the walls that coincide with no other at rest, by a penalty; in the plane only.

    Parameters
    ----------
    walls : Surface
        The walls.
    modulus_of_body : array of float, shape (bodies,)
        Plane-strain modulus of each body [stress].
    reach : float or array of float, shape (bodies,)
        Distance up to which walls are paired [length].
    options : ContactOptions
        The solver's own numbers.
    """
    free = np.setdiff1d(np.arange(walls.facet_count), coincident_facets(walls))
    if not isinstance(walls, EdgeSurface) or len(np.unique(walls.body[free])) < 2:
        return ()
    mine = walls.chosen(free)
    stiffness = penalty_stiffness(mine, modulus_of_body, options.penalty_multiple)
    return (ContactAroundSpaces(PenaltyContact(mine, stiffness, reach, options=options)),)
