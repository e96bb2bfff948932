"""The exponential cohesive law, given by a strength and an energy of separation.

The traction of a bond that opens is

    T(lambda) = strength (lambda / peak) exp(1 - lambda / peak),     energy = e strength peak

which rises to `strength` at the opening `peak`, falls off behind it, and takes `energy` per reference length to
separate: both numbers are the user's, and no penalty is needed (Smith-Ferrante law as in Ortiz & Pandolfi 1999,
doi:10.1002/(SICI)1097-0207(19990330)44:9<1267::AID-NME486>3.0.CO;2-7, with shear and normal weighed alike).
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.scene.scope import refuse
from ngcell.scene.section import PositiveNumber, Section

Array = NDArray[np.float64]


class Cohesion(Section):
    """Bonds between all walls that coincide at rest; contact in compression stays as it is.

    The traction grows to `strength`, at the opening ``energy / (e * strength)``, and falls off exponentially behind it.

    Parameters
    ----------
    strength : float
        Largest traction between two walls, a stress, > 0; sliding and parting count alike.
    energy : float
        Energy that separates a unit of wall length at rest, of prisms of wall area, stress times length, > 0.
    """

    kind: Literal["exponential"] = "exponential"
    strength: PositiveNumber
    energy: PositiveNumber

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse contact and lumens with multipliers: each step in which walls snap apart would take hours."""
        if not getattr(scene.get("contact"), "goes_with_cohesion", True):
            refuse('does not go with contact.kind = "mortar"; allowed: contact.kind = "penalty" or "ngsolve"')
        if not getattr(scene.get("lumen"), "goes_with_cohesion", True):
            refuse('does not go with lumen.kind = "fluid"; allowed: another lumen, or none')
        if not getattr(scene.get("strategy"), "goes_with_history", True):
            refuse('does not go with strategy.kind = "single-step"; allowed: "sddp" or "load-stepping"')

    @property
    def peak(self) -> float:
        """Opening at the largest traction [length]."""
        return float(self.energy / (np.e * self.strength))

    @property
    def stiffness_at_rest(self) -> float:
        """Traction over opening of a whole bond [stress / length]."""
        return float(np.e * self.strength / self.peak)

    def traction(self, opening: Array) -> Array:
        """Return the traction of bonds that open [stress]."""
        return self.secant(opening) * opening

    def secant(self, opening: Array) -> Array:
        """Return the traction over the opening [stress / length]."""
        return np.asarray(self.stiffness_at_rest * np.exp(-opening / self.peak))

    def secant_slope(self, opening: Array) -> Array:
        """Return the derivative of `secant` by the opening [stress / length**2]."""
        return -self.secant(opening) / self.peak

    def work(self, opening: Array) -> Array:
        """Return the work of opening a bond for the first time [stress * length]."""
        share = opening / self.peak
        return np.asarray(-self.energy * (np.expm1(-share) + share * np.exp(-share)))
