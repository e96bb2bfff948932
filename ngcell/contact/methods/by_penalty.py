"""Contact by a penalty on the overlap: its section in a case, and its continuation stages."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.protocol import ContactMethod
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach
from ngcell.contact.surface.surface import Surface
from ngcell.scene.section import PositiveNumber, Section

Array = NDArray[np.float64]


class Penalty(Section):
    """Frictionless unilateral contact by a penalty on the overlap.

    Parameters
    ----------
    stiffness : float
        Multiple of the penalty stiffness that is derived from material, mesh and accuracy, > 0, without unit.
    single_pass_corners : bool
        Whether next to convex corners of planar walls only the corner's wall is integrated, elsewhere both: corners
        then slide without bumps at the quadrature points of other walls, and cells slide farther. Prisms and other
        solids have both passes, whatever it says.
    """

    kind: Literal["penalty"] = "penalty"
    stiffness: PositiveNumber = 1.0
    single_pass_corners: bool = True
    goes_with_cohesion: ClassVar[bool] = True

    def stages(
        self, walls: Surface, modulus_of_body: Array, *, reach: Reach, options: ContactOptions = DEFAULT_OPTIONS
    ) -> tuple[ContactMethod, ...]:
        """Return penalties from the softest to the one that is meant; see `ngcell.contact.methods.stages`."""
        meant = options.penalty_multiple * self.stiffness
        multiples = (*options.path_multiples(meant), meant)
        stiffnesses = [penalty_stiffness(walls, modulus_of_body, multiple) for multiple in multiples]
        return tuple(
            PenaltyContact(walls, each, reach, single_pass_corners=self.single_pass_corners, options=options)
            for each in stiffnesses
        )
