"""The certificate: what an accepted step is judged by, and with which limits.

Every number is measured on the finished state, as far as possible by other means than those of the solver: overlaps
also from polygons, forces from walls as well as from supports, work from supports and energy from bodies.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

#: Limits, by check; each is the largest value that passes, unless said otherwise.
LIMITS = {
    "residual": 1e-6,
    "penetration_over_wall": 0.02,
    "tension": 0.0,
    "complementarity": 0.02,
    "weighted_overlap": 1e-6,
    "weighted_complementarity": 1e-6,
    "lumen_area": 1e-8,
    "body_balance": 1e-3,
    "plate_balance": 1e-3,
    "smallest_jacobian": 0.0,
    "stabilisation": 1e-3,
    "work_mismatch": 1e-3,
    "energy_balance": 1e-3,
}
MEANING = {
    "residual": "norm of the forces out of balance, beyond those that last digits of positions stand for, over that of "
    "the internal forces",
    "penetration_over_wall": "deepest overlap, from contact and from outlines, over the thinnest wall",
    "tension": "largest tensile contact pressure over the shear modulus",
    "complementarity": "integral of contact pressure times gap over the stored energy",
    "weighted_overlap": "deepest overlap averaged by a multiplier's function over the thinnest wall; mortar only",
    "weighted_complementarity": "sum of multipliers times weighted gaps over the stored energy; mortar only",
    "lumen_area": "largest deviation of a lumen's area or volume from that of its fluid, relative; fluids only",
    "body_balance": "largest force out of balance on a body over the largest force in play",
    "plate_balance": "sum of all support forces over the largest force in play",
    "smallest_jacobian": "smallest ratio of deformed to reference volume; must exceed the limit",
    "stabilisation": "norm of the nodal forces of what is left of the proximal term over that of the internal forces",
    "work_mismatch": "work of the supports minus change of energy, beyond quadrature, over the energy; tied steps",
    "energy_balance": "work minus change of stored energy, energy of separation and losses, over what a step moves; "
    "with cohesion",
}


@dataclass(frozen=True)
class Check:
    """One line of the certificate.

    Attributes
    ----------
    name : str
        A key of `LIMITS`.
    value : float
        What was measured, without unit.
    """

    name: str
    value: float

    @property
    def limit(self) -> float:
        """What the value is held to."""
        return LIMITS[self.name]

    @property
    def passed(self) -> bool:
        """Whether the value keeps the limit; NaN never does."""
        if self.name == "smallest_jacobian":
            return self.value > self.limit
        return self.value <= self.limit


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
            if old is None or _is_worse(check, old):
                table[check.name] = check
    return table


def _is_worse(check: Check, other: Check) -> bool:
    if check.value != check.value:
        return True
    return check.value < other.value if check.name == "smallest_jacobian" else check.value > other.value
