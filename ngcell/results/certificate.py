"""The certificate: what an accepted step is judged by.

Every number is measured on the finished state, as far as possible by other means than those of the solver: overlaps
also from polygons, forces from walls as well as from supports, work from supports and energy from bodies. Checks that
belong to an effect, such as contact, come from its term.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, isfinite

from ngcell.mechanics.report import Check

#: Limits of the checks of all scenes: the largest value that passes, unless said otherwise. That of quadrature is
#: below the 4 to 8 % by which the energy of a tissue errs at order 3 with two elements a side.
LIMITS = {
    "residual": 1e-6,
    "penetration_over_wall": 0.02,
    "body_balance": 1e-3,
    "plate_balance": 1e-3,
    "self_penetration_over_wall": 0.02,
    "smallest_jacobian": 0.0,
    "quadrature_error": 0.05,
    "stabilisation": 1e-3,
    "work_mismatch": 1e-3,
    "energy_above_tied": 1e-3,
    "lowest_curvature": -1e-5,
    "energy_balance": 1e-3,
}
#: Shares of forces that the proximal term may still hold: where an accuracy is asked for, so much of it.
HELD, HELD_OF_ACCURACY = ("body_balance", "plate_balance", "stabilisation"), 0.1
_MEANING = {
    "residual": "norm of the forces out of balance, beyond those that last digits of positions stand for, over that of "
    "the internal forces",
    "penetration_over_wall": "deepest overlap, from contact, from outlines and, in the plane, from areas that two "
    "bodies share, over the thinnest wall",
    "self_penetration_over_wall": "thickness of what a body covers twice, lumens inside out included, over the "
    "thinnest wall; in the plane",
    "body_balance": "largest force out of balance on a body over the largest force in play",
    "plate_balance": "sum of all support forces over the force that goes through them, from one plate to the other, or "
    "over the largest force in play, if that is more",
    "smallest_jacobian": "lower bound of the ratio of deformed to reference volume anywhere in elements; must "
    "exceed the limit",
    "quadrature_error": "stored energy by a rule of twice the degree minus that reported, over the energy",
    "stabilisation": "norm of the nodal forces of the proximal term that is left over that of the internal forces",
    "work_mismatch": "work of supports and loads minus change of energy, beyond quadrature along the load path, over "
    "the energy; of tied steps, and where it lacks, of released steps that start from the step before",
    "energy_above_tied": "potential of the released walls above that of the tied state at the same load, over the "
    "energy; released steps of SDDP",
    "lowest_curvature": "lowest eigenvalue of the tangent in the metric of the volume, closed contacts held closed, "
    "over shear modulus by squared size of a body; a negative one is a saddle; must exceed the limit. Not sought "
    "where systems are solved by iterations",
    "energy_balance": "work minus change of stored energy, energy of separation and losses, over what a step moves; "
    "with a history",
}
#: Checks whose limit is a lower one. That of curvatures is round-off beside the weight that they are found with.
_MUST_EXCEED = ("smallest_jacobian", "lowest_curvature")


def common_check(name: str, value: float, place: str = "", *, accuracy: float = inf) -> Check:
    """Return a check of all scenes, at the relative error that is asked for, if one is."""
    limit = HELD_OF_ACCURACY * accuracy if name in HELD and isfinite(accuracy) else LIMITS[name]
    return Check(name, value, limit, _MEANING[name], must_exceed=name in _MUST_EXCEED, place=place)


@dataclass(frozen=True)
class Certificate:
    """All checks of one step."""

    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[str, ...]:
        """Names of the checks that failed."""
        return tuple(check.name for check in self.checks if not check.passed)


def worst(certificates: Iterable[Certificate]) -> dict[str, Check]:
    """Return the worst value of each check over many steps."""
    table: dict[str, Check] = {}
    for certificate in certificates:
        for check in certificate.checks:
            old = table.get(check.name)
            if old is None or check.is_worse_than(old):
                table[check.name] = check
    return table
