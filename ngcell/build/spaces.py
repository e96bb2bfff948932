"""Contact of the tied solid around spaces between cells: of the walls that the tie leaves free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.by_penalty import Penalty
from ngcell.contact.methods.protocol import Adapting
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.options import ContactOptions
from ngcell.contact.pairing.near import Reach
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import Term
from ngcell.problem.tie import coincident_facets


class ContactAroundSpaces(ContactTerm):
    """Contact of one stage: its penalty terms follow no softer ones, and begin to adapt with each tied state."""

    def reset(self) -> None:
        """Forget what the penalty was raised to, and let it adapt again."""
        if isinstance(self.method, Adapting):
            self.method.restart()


def contact_around_spaces(
    penalty: Penalty, walls: Surface, modulus_of_body: NDArray[np.float64], reach: Reach, options: ContactOptions
) -> tuple[Term, ...]:
    """Return contact by a penalty of the walls that coincide with no other at rest; in the plane only.

    Parameters are those of `ngcell.contact.methods.stages.ContactChoice.stages`.
    """
    free = np.setdiff1d(np.arange(walls.facet_count), coincident_facets(walls))
    if not isinstance(walls, EdgeSurface) or len(np.unique(walls.body[free])) < 2:
        return ()
    *_, meant = penalty.stages(walls.chosen(free), modulus_of_body, reach=reach, options=options)
    return (ContactAroundSpaces(meant),)
