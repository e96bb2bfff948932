"""How hard cells press on themselves."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.self_contact import SelfContact
from ngcell.results.quantities import View
from ngcell.scene.section import Section


class SelfContactForce(Section):
    """Contact forces within each lumen that has closed, their magnitudes added up for each cell [stress * length].

    They are per unit of depth in the plane.

    Forces between cells are no part of it.
    """

    kind: Literal["self-contact-force"] = "self-contact-force"

    @property
    def name(self) -> str:
        """Name of the column and of the field."""
        return "self_contact_force"

    def values(self, view: View) -> NDArray[np.float64]:
        """Return the force in each body, shape (bodies,)."""
        count = view.problem.space.body_count
        found = [term for term in view.problem.terms if isinstance(term, SelfContact)]
        return sum((term.force_in_bodies(view.state.at, count) for term in found), np.zeros(count))
