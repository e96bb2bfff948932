"""From the choice in a case to contact methods: the soft ones of the continuation, and the one that is meant.

A further contact method is one file beside this one, with a section that offers `stages`, and one line in
`ngcell.scene.registry`; a script may hand over any object that is a `ContactChoice`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.protocol import ContactMethod
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactOptions:
    """The solver's own numbers of contact: stiffness of penalty terms, in layers of elements behind the wall.

    Attributes
    ----------
    penalty_multiple : float
        Stiffness of the penalty method that is meant, > 0.
    path_multiple : float
        Stiffness with which continuation paths are followed, > 0: as stiff as the layer behind the wall, it costs a
        third of the iterations.
    stage_factor : float
        Factor between the stages from there to the one that is meant, > 1.
    mortar_multiple : float
        Stiffness of the mortar method, > 0. The result does not depend on it: softer terms need more updates of the
        multipliers, stiffer ones more steps to each.
    handover_multiple : float
        Stiffness of the last penalty method before the mortar method takes over, > 0: walls overlap so little that they
        do not jump apart.
    """

    penalty_multiple: float = 10.0
    path_multiple: float = 1.0
    stage_factor: float = 10.0
    mortar_multiple: float = 3.0
    handover_multiple: float = 3.0

    def path_multiples(self, meant: float) -> list[float]:
        """Return the stiffnesses of the stages before the one that is meant, the softest first; at least one."""
        multiples, multiple = [], self.path_multiple
        while multiple < meant * (1 - 1e-9):
            multiples.append(multiple)
            multiple *= self.stage_factor
        return multiples or [meant]


#: What is used unless somebody hands down other numbers.
DEFAULT_OPTIONS = ContactOptions()


@runtime_checkable
class ContactChoice(Protocol):
    """What walls do to each other, as a case says it."""

    @property
    def goes_with_cohesion(self) -> bool:
        """Whether walls may be bonded as well."""

    def stages(
        self, walls: Surface, modulus_of_body: Array, *, reach: float, options: ContactOptions = DEFAULT_OPTIONS
    ) -> tuple[ContactMethod | Term, ...]:
        """Return contact from the softest, with which continuation paths are followed, to the one that is meant.

        Parameters
        ----------
        walls : Surface
            The walls.
        modulus_of_body : array of float, shape (bodies,)
            Plane-strain modulus of each body [stress].
        reach : float
            Distance up to which walls are paired [length].
        options : ContactOptions
            The solver's own numbers.
        """
