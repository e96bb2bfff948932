"""Contact by a mortar method: its section in a case, and its continuation stages."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.by_penalty import Penalty
from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.protocol import ContactMethod
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach
from ngcell.contact.surface.surface import Surface
from ngcell.scene.section import Section

Array = NDArray[np.float64]


class Mortar(Section):
    """Frictionless unilateral contact by a mortar method: the contact pressure is an unknown.

    Walls overlap nowhere on average over an edge; single points may, by less than the certificate allows.
    """

    kind: Literal["mortar"] = "mortar"
    goes_with_cohesion: ClassVar[bool] = False

    def stages(
        self, walls: Surface, modulus_of_body: Array, *, reach: Reach, options: ContactOptions = DEFAULT_OPTIONS
    ) -> tuple[ContactMethod, ...]:
        """Return two penalties, then the mortar method; see `ngcell.contact.methods.stages`.

        Where equilibria only lead to those on finer meshes, they are those of the penalty method: which of them walls
        find hardly depends on its overlaps, and its multipliers would be thrown away.
        """
        if options.only_leads:
            return Penalty().stages(walls, modulus_of_body, reach=reach, options=options)
        path, handover, own = (
            penalty_stiffness(walls, modulus_of_body, multiple)
            for multiple in (options.path_multiple, options.penalty_multiple, options.mortar_multiple)
        )
        return (
            PenaltyContact(walls, path, reach, single_pass_corners=True, options=options),
            PenaltyContact(walls, handover, reach, single_pass_corners=True, options=options.before_multipliers),
            MortarContact(walls, own, reach, options),
        )
