"""What a cohesive law offers, whichever it is: the traction of a bond over its opening, and the work that it takes.

A further law is one file beside this one and one line in `ngcell.scene.registry`; a script may hand over any object
with these members.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@runtime_checkable
class CohesiveLaw(Protocol):
    """The law of traction over opening of a bond that opens further than ever before.

    Openings are lengths, >= 0, tractions stresses, >= 0; arrays have any shape and keep it. The traction over the
    opening, the secant stiffness, does not grow with the opening.
    """

    @property
    def peak(self) -> float:
        """Largest opening at full strength [length], > 0: a bond that has been opened further counts as broken."""

    @property
    def stiffness_at_rest(self) -> float:
        """Traction over opening of a whole bond [stress / length], finite and > 0."""

    def traction(self, opening: Array) -> Array:
        """Return the traction [stress]."""

    def secant(self, opening: Array) -> Array:
        """Return the traction over the opening [stress / length], also where the opening is 0."""

    def secant_slope(self, opening: Array) -> Array:
        """Return the derivative of `secant` by the opening [stress / length**2], <= 0."""

    def work(self, opening: Array) -> Array:
        """Return the work of opening a bond for the first time [stress * length]."""
