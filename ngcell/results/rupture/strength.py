"""How near walls are to rupture: averages of stress and stretch beside what the material bears.

The measures of an average are the largest principal value of the mean Cauchy stress, over the deformed part of the
body, beside the strength; and the largest principal stretch of the mean deformation gradient, over the part at rest,
beside the limit of stretch. The utilisation is the larger of

    stress / strength     and     (stretch - 1) / (stretch_limit - 1),

0 at rest and 1 where the wall ruptures. It is evaluated on states that know nothing of it: no wall is taken away.

Stresses have the volume ratio projected to one order less: the bulk modulus times what a displacement of this order
says of it goes up and down within elements. On an inflated ring of order 3 they err by 6e-5, 2e-4 and 6e-4 at kappa/mu
of 100, 300 and 900, and by 3e-4, 1e-3 and 4e-3 without. In sheared cells under pressure (order 3, beside order 6) they
err by 0.8, 1 and 3 % at 50, 100 and 300, and by 69, 150 and 470 % without; on meshes that are graded towards corners by
1 to 3 % at 5 to 50 either way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.mixed import INCOMPRESSIBLE, is_incompressible
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.term import Term
from ngcell.problem.reports import stress as cauchy_stress
from ngcell.results.rupture.averages import averages_of

Array = NDArray[np.float64]

#: Share below which utilisations of bodies that are alike by symmetry differ.
_ALIKE = 1e-6
#: Further columns of the table of steps.
COLUMNS = ("utilisation", "utilisation_error", "utilisation_cell", "utilisation_x", "utilisation_y")


@dataclass(frozen=True, eq=False)
class Utilisation:
    """How near walls are to rupture in one state.

    Attributes
    ----------
    of_body : array of float, shape (bodies,)
        Largest utilisation of each body [1], >= 0; NaN where an element is inverted.
    place : array of float, shape (bodies, dimension)
        Where that is, at rest [length].
    """

    of_body: Array
    place: Array

    @property
    def body(self) -> int:
        """The body that is nearest to rupture, the first of those that are as near but for round-off."""
        known = np.where(np.isnan(self.of_body), -1.0, self.of_body)
        return int(np.flatnonzero(known >= known.max() - _ALIKE * abs(known.max()))[0])

    @property
    def largest(self) -> float:
        """Largest utilisation of all bodies [1]."""
        return float(self.of_body.max())

    def columns(self, error: float) -> dict[str, float]:
        """Return the further columns of a step, with the estimated error of the largest utilisation."""
        x, y = self.place[self.body].tolist()
        return dict(zip(COLUMNS, (self.largest, error, float(self.body), x, y), strict=True))


class WallStrength:
    """What walls bear.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    strength : array of float, shape (bodies,)
        Largest principal Cauchy stress that each body bears on average [stress], > 0; infinite where nothing is said.
    stretch_limit : array of float, shape (bodies,)
        Largest principal stretch that it bears on average [1], > 1; infinite where nothing is said.
    length : array of float, shape (bodies,)
        Length of the averages [length], > 0.

    Attributes
    ----------
    averages : Averages
        The averages.

    Raises
    ------
    CaseError
        If bodies are not planar, or a length is far too short for their elements.
    """

    def __init__(self, space: DisplacementSpace, strength: Array, stretch_limit: Array, length: Array) -> None:
        if space.dimension != 2:
            raise CaseError("material.strength and material.stretch_limit; allowed: in planar scenes")
        self._strength, self._stretch_limit = strength, stretch_limit
        self.averages = averages_of(space, length)

    def utilisation(self, terms: Sequence[Term], displacement: Array) -> Utilisation:
        """Return how near walls are to rupture with a displacement, shape (unknowns,)."""
        gradient = self.averages.samples.deformation_gradient(displacement)
        body, share = self.averages.body, np.zeros(len(self.averages.body))
        if np.isfinite(self._strength).any():
            stressed = self.averages.samples.with_projected_volume(displacement, gradient)
            share = np.maximum(share, self.principal_stress(terms, stressed) / self._strength[body])
        if np.isfinite(self._stretch_limit).any():
            share = np.maximum(share, (self.principal_stretch(gradient) - 1) / (self._stretch_limit[body] - 1))
        order = np.lexsort((share, body))
        last = order[np.append(np.flatnonzero(np.diff(body[order])), len(order) - 1)]
        return Utilisation(share[last], self.averages.place[last])

    def principal_stress(self, terms: Sequence[Term], gradient: Array) -> Array:
        """Return the largest principal value of each mean Cauchy stress [stress], shape (averages,)."""
        samples = self.averages.samples
        stress = cauchy_stress(terms, gradient, samples.element)
        jacobian = np.linalg.det(gradient)
        mean = self.averages.sums(stress * jacobian[:, None, None]) / self.averages.sums(jacobian)[:, None, None]
        is_finite = np.isfinite(mean).all((1, 2))
        principal = np.full(len(mean), np.nan)
        principal[is_finite] = np.linalg.eigvalsh(mean[is_finite])[:, -1]
        return principal

    def principal_stretch(self, gradient: Array) -> Array:
        """Return the largest principal stretch of each mean deformation gradient [1], shape (averages,)."""
        whole = self.averages.sums(np.ones(len(gradient)))
        return np.asarray(np.linalg.svd(self.averages.sums(gradient) / whole[:, None, None], compute_uv=False)[:, 0])


def wall_strength(space: DisplacementSpace, laws: Sequence[HyperelasticLaw]) -> WallStrength | None:
    """Return what walls of these laws bear, one law a body; None where none says it.

    Raises
    ------
    CaseError
        If a wall with a strength hardly changes its volume: the displacement alone does not tell its mean stress.
    """

    def said(name: str) -> list[float | None]:
        return [getattr(law, name, None) for law in laws]

    strength, limit, length = said("strength"), said("stretch_limit"), said("rupture_length")
    if all(value is None for value in (*strength, *limit)):
        return None
    if any(value is not None and is_incompressible(law) for value, law in zip(strength, laws, strict=True)):
        raise CaseError(
            f"material.strength: not for a bulk modulus above {INCOMPRESSIBLE:.0f} shear moduli; allowed: "
            "a smaller bulk_modulus, or a stretch_limit"
        )
    thickness = space.bodies.thickness_of_body
    return WallStrength(
        space,
        np.array([inf if value is None else value for value in strength]),
        np.array([inf if value is None else value for value in limit]),
        np.array([own if value is None else value for own, value in zip(thickness, length, strict=True)]),
    )
