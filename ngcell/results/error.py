"""How far reported numbers are from those of an endless refinement, told from what the refinements so far have changed.

With a remaining share r of the error from one mesh to the next, numbers q on two of them differ by (1 - r) times the
error of the coarser one: the finer one errs by ``|q - q'| r / (1 - r)``. The share is measured where there are three
meshes, from how much less the second refinement has changed the energy than the first; it is never taken smaller than
what the strongest singularity of the bodies lets remain, and never larger than `MOST_REMAINS`. Beside the mesh, the
energy errs by contact that is not rigid, at most by forces times overlaps, and energy and plate force by what the
proximal term still holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.report import Check

Array = NDArray[np.float64]

#: The largest share of an error that a refinement is taken to leave.
MOST_REMAINS = 0.8
_MEANING = "largest estimated relative error of energy, plate force and mean gap of held walls; by refinement"


@dataclass(frozen=True, eq=False)
class Numbers:
    """The numbers of one step on one mesh that errors are estimated for.

    Attributes
    ----------
    energy : float
        Stored energy [stress * length**2].
    plate_force : array of float, shape (dimension,)
        Force of the moved support [stress * length].
    contact_force : float
        Sum of the magnitudes of forces between walls [stress * length].
    mean_gap, largest_gap : float
        Gaps of walls between held bodies [length].
    scales : tuple of float
        Energy, force and gap below which nothing is told apart.
    besides : float
        What the energy may err by besides the mesh [stress * length**2].
    pulled : float
        What the proximal term that is left takes of the force from one support to the other [stress * length].
    """

    energy: float
    plate_force: Array
    contact_force: float
    mean_gap: float
    largest_gap: float
    scales: tuple[float, float, float]
    besides: float = 0.0
    pulled: float = 0.0


@dataclass(frozen=True)
class Errors:
    """Estimated errors, in the units of the numbers; NaN where none was estimated.

    Attributes
    ----------
    energy, plate_force, contact_force, mean_gap, largest_gap : float
        Errors of the numbers of the same names.
    relative : float
        The largest relative error of energy, plate force and mean gap.
    """

    energy: float = nan
    plate_force: float = nan
    contact_force: float = nan
    mean_gap: float = nan
    largest_gap: float = nan
    relative: float = nan

    def check(self, accuracy: float) -> Check:
        """Return the check of the certificate: a number that is not known fails it."""
        return Check("estimated_error", self.relative if isfinite(self.relative) else inf, accuracy, _MEANING)


#: Nothing was estimated.
NO_ERRORS = Errors()
#: Numbers whose errors are reported.
ERROR_NAMES = ("energy", "plate_force", "contact_force", "mean_gap", "largest_gap")


def estimate(found: Sequence[Numbers], remains: float, *, of_last: bool = True) -> Errors:
    """Return the errors of numbers that were found on one mesh after the other.

    Parameters
    ----------
    found : sequence of Numbers
        On each mesh, the coarsest first.
    remains : float
        Smallest share of the error that the last refinement may have left, in (0, 1).
    of_last : bool
        Whether errors are those of the last mesh, or of the last but one.
    """
    if len(found) < 2:
        return Errors()
    last = found[-1]

    changes = [_change(one, two, "energy") for one, two in zip(found, found[1:], strict=False)]
    measured = changes[-1] / changes[-2] if len(changes) > 1 and changes[-2] > 0 else 0.0
    share = min(max(measured, remains), MOST_REMAINS)

    def error(name: str) -> float:
        return _change(found[-2], last, name) * (share if of_last else 1.0) / (1 - share)

    energy = error("energy") + last.besides
    force, contact = error("plate_force") + last.pulled, error("contact_force")
    mean, largest = error("mean_gap"), error("largest_gap")
    scales = last.scales
    relative = max(
        energy / max(abs(last.energy), scales[0]),
        force / max(float(np.linalg.norm(last.plate_force)), scales[1]),
        mean / max(abs(last.mean_gap), scales[2]),
    )
    return Errors(energy, force, contact, mean, largest, relative)


def _change(one: Numbers, two: Numbers, name: str) -> float:
    return float(np.linalg.norm(np.atleast_1d(getattr(two, name) - getattr(one, name))))
