"""From the choice in a case to contact methods: the soft ones that a path is followed with, and the one that is meant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.penalty import PenaltyContact, penalty_stiffness
from ngcell.contact.methods.protocol import ContactMethod
from ngcell.contact.surface.surface import Surface
from ngcell.scene import Mortar, Penalty

Array = NDArray[np.float64]

#: Stiffness of the penalty terms in layers of elements: of the penalty that is meant, of the one with which continuation paths are
#: followed (as stiff as the layer behind the wall, it costs a third of the iterations), and of the mortar method, whose
#: result does not know it: softer penalty terms need more updates of the pressures, stiffer ones more steps to each. In
#: between penalties rise by steps of `STAGE_FACTOR`; the last before the mortar method overlaps so little that walls do not
#: jump apart where it takes over.
PENALTY_MULTIPLE, PATH_MULTIPLE, MORTAR_MULTIPLE, STAGE_FACTOR = 10.0, 1.0, 3.0, 10.0
HANDOVER_MULTIPLE = 3.0


def contact_stages(
    choice: Penalty | Mortar, walls: Surface, modulus_of_body: Array, reach: float
) -> tuple[ContactMethod, ...]:
    """Return contact from the softest, with which paths are followed, to the one that is meant.

    Parameters
    ----------
    choice : Penalty or Mortar
        The choice.
    walls : Surface
        The walls.
    modulus_of_body : array of float, shape (bodies,)
        Plane-strain modulus of each body [stress].
    reach : float
        Distance up to which walls are paired [length].
    """

    def penalty(multiple: float, *, may_stiffen: bool = True) -> ContactMethod:
        return PenaltyContact(
            walls, penalty_stiffness(walls, modulus_of_body, multiple), reach, may_stiffen=may_stiffen
        )

    if isinstance(choice, Mortar):
        stiffness = penalty_stiffness(walls, modulus_of_body, MORTAR_MULTIPLE)
        handover = penalty(HANDOVER_MULTIPLE, may_stiffen=False)
        return penalty(PATH_MULTIPLE), handover, MortarContact(walls, stiffness, reach)
    meant = PENALTY_MULTIPLE * choice.stiffness
    return tuple(penalty(multiple) for multiple in (*(_softer(meant) or [meant]), meant))


def _softer(meant: float) -> list[float]:
    multiples, multiple = [], PATH_MULTIPLE
    while multiple < meant * (1 - 1e-9):
        multiples.append(multiple)
        multiple *= STAGE_FACTOR
    return multiples
