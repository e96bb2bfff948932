"""From the choice in a case to contact methods: the soft ones of the continuation, and the one that is meant.

A further contact method is one file beside this one, with a section that offers `stages`, and one line in
`ngcell.scene.registry`; a script may hand over any object that is a `ContactChoice`.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.protocol import ContactMethod
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import Term

Array = NDArray[np.float64]


@runtime_checkable
class ContactChoice(Protocol):
    """What walls do to each other, as a case says it."""

    @property
    def goes_with_cohesion(self) -> bool:
        """Whether walls may be bonded as well."""

    def stages(
        self, walls: Surface, modulus_of_body: Array, *, reach: Reach, options: ContactOptions = DEFAULT_OPTIONS
    ) -> tuple[ContactMethod | Term, ...]:
        """Return contact from the softest, with which continuation paths are followed, to the one that is meant.

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
