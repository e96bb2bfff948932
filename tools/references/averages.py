"""Averages of exact stresses: a plate with a hole, and a ring under pressure.

    python -m tools.references averages

- A plate with a hole of radius a, free, whose outer circle of radius b is displaced affinely: Michell's series of small
  strain, of which this takes the terms 1 and cos 2t (Barber, Elasticity, table 8.1 and 9.1). For b -> infinity it is
  Kirsch's plate, with three times the remote stress at the hole.
- A ring in finite strain under pressure: the radial solution of `tools.references.radial`. The mean of the hoop stress
  over the thickness is P a / (b - a) by balance of forces alone, with the deformed radii.

Averages are those over a disc around a point, as far as it lies in the body, with the weights (1 - r^2/l^2)^2. Nothing
is shared with the package.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from tools.commands import described
from tools.references.radial import RadialSolid, inflated_radius, profile

Array = NDArray[np.float64]
#: Stress along the radius, around it, and their shear, at a radius and an angle.
PolarStress = Callable[[Array, Array], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class HoledPlate:
    """A plate in plane strain whose circle of radius `outer` has the displacement (strains[0] x, strains[1] y)."""

    inner: float
    outer: float
    strains: tuple[float, float]
    shear: float
    bulk: float

    @property
    def poisson(self) -> float:
        """Poisson's ratio."""
        return (3 * self.bulk - 2 * self.shear) / (2 * (3 * self.bulk + self.shear))

    @cached_property
    def _even(self) -> tuple[float, float]:
        """A and B of the displacement A r + B / r along the radius."""
        plane = 2 * self.shear / (1 - 2 * self.poisson)  # twice the plane bulk modulus
        mean = sum(self.strains) / 2
        rows = [[plane, -2 * self.shear / self.inner**2], [1, 1 / self.outer**2]]
        a, b = np.linalg.solve(rows, [0, mean])
        return float(a), float(b)

    @cached_property
    def _double(self) -> Array:
        """Coefficients of r^2, r^4, r^-2 and 1, times cos 2t, in Airy's function."""
        kolosov, a, b = 3 - 4 * self.poisson, self.inner, self.outer
        half = (self.strains[0] - self.strains[1]) / 2
        rows = [
            [-2, 0, -6 / a**4, -4 / a**2],
            [2, 6 * a**2, -6 / a**4, -2 / a**2],
            [-2 * b, (kolosov - 3) * b**3, 2 / b**3, (kolosov + 1) / b],
            [2 * b, (kolosov + 3) * b**3, 2 / b**3, -(kolosov - 1) / b],
        ]
        moved = 2 * self.shear * half * b
        return np.asarray(np.linalg.solve(rows, [0, 0, moved, -moved]))

    def stress(self, radius: Array, angle: Array) -> tuple[Array, Array, Array]:
        """Stress along the radius, around it, and their shear."""
        plane, (a, b), (c1, c2, c3, c4) = 2 * self.shear / (1 - 2 * self.poisson), self._even, self._double
        cos, sin = np.cos(2 * angle), np.sin(2 * angle)
        even, odd = plane * a, 2 * self.shear * b / radius**2
        along = even - odd + cos * (-2 * c1 - 6 * c3 / radius**4 - 4 * c4 / radius**2)
        around = even + odd + cos * (2 * c1 + 12 * c2 * radius**2 + 6 * c3 / radius**4)
        shear = sin * (2 * c1 + 6 * c2 * radius**2 - 6 * c3 / radius**4 - 2 * c4 / radius**2)
        return along, around, shear


def averaged(
    stress: PolarStress, middle: tuple[float, float], length: float, radii: tuple[float, float], count: int = 80
) -> float:
    """Largest principal value of the mean stress in the disc of radius `length` around the point at (radius, angle).

    `radii` are those between which the body lies; stress may carry further weights.
    """
    points, weights = np.polynomial.legendre.leggauss(count)
    low, high = max(radii[0], middle[0] - length), min(radii[1], middle[0] + length)
    radius = low + (high - low) * (points + 1) / 2
    half = np.arccos(np.clip((radius**2 + middle[0] ** 2 - length**2) / (2 * radius * middle[0]), -1, 1))
    angle = half[:, None] * points
    square = radius[:, None] ** 2 + middle[0] ** 2 - 2 * radius[:, None] * middle[0] * np.cos(angle)
    weight = (1 - square / length**2).clip(0) ** 2 * np.outer(weights * half * radius, weights)
    along, around, shear = (np.broadcast_to(part, angle.shape) for part in stress(radius[:, None], middle[1] + angle))
    cos, sin = np.cos(angle), np.sin(angle)
    xx = along * cos**2 + around * sin**2 - 2 * shear * sin * cos
    yy = along * sin**2 + around * cos**2 + 2 * shear * sin * cos
    xy = (along - around) * sin * cos + shear * (cos**2 - sin**2)
    mean = np.array([[(weight * xx).sum(), (weight * xy).sum()], [(weight * xy).sum(), (weight * yy).sum()]])
    return float(np.linalg.eigvalsh(mean / weight.sum())[-1])


def largest_at_hole(plate: HoledPlate, length: float) -> float:
    """Largest average along the line from the hole across the direction of the larger strain."""
    angle = np.pi / 2 if plate.strains[0] > plate.strains[1] else 0.0
    middles = plate.inner + length * np.linspace(0, 1, 41)
    return max(averaged(plate.stress, (r, angle), length, (plate.inner, plate.outer)) for r in middles)


@dataclass(frozen=True)
class InflatedRing:
    """A ring with free rim under a pressure inside."""

    solid: RadialSolid
    inner: float
    outer: float
    pressure: float

    @cached_property
    def radii(self) -> tuple[float, float]:
        """Deformed radii of bore and rim."""
        bore = inflated_radius(self.solid, self.inner, self.outer, self.pressure)
        return bore, float(profile(self.solid, self.inner, self.outer, bore, self.pressure)(self.outer)[0])

    @property
    def mean_hoop(self) -> float:
        """Mean of the hoop stress over the thickness."""
        bore, rim = self.radii
        return self.pressure * bore / (rim - bore)

    def average(self, length: float) -> float:
        """Largest average over discs, each over the material that they hold at rest, by deformed volume."""
        at = profile(self.solid, self.inner, self.outer, self.radii[0], self.pressure)
        middles = np.linspace(self.inner, self.outer, 21)
        radii = self.inner, self.outer

        def weighed(radius: Array, angle: Array) -> tuple[Array, Array, Array]:
            (place, along), zero = at(radius.ravel()), np.zeros_like(angle)
            stretch = (place / radius.ravel()).reshape(radius.shape)
            slopes = self.solid.slopes(along.reshape(radius.shape), stretch)
            # The Cauchy stress times J is the stretch times dW / d(stretch).
            return slopes[0] * along.reshape(radius.shape) + zero, slopes[1] * stretch + zero, zero

        def volume(radius: Array, angle: Array) -> tuple[Array, Array, Array]:
            (place, along), zero = at(radius.ravel()), np.zeros_like(angle)
            ratio = (along * place / radius.ravel()).reshape(radius.shape) + zero
            return ratio, ratio, zero

        return max(
            averaged(weighed, (middle, 0.0), length, radii) / averaged(volume, (middle, 0.0), length, radii)
            for middle in middles
        )


@described(__doc__)
def command() -> None:
    """Print averages of both fields."""
    for outer in (4.0, 40.0, 4000.0):
        # Remote tension along x alone, in plane strain with nu = 0.3: kappa / mu = 13/6.
        plate = HoledPlate(1.0, outer, (0.7 / 2, -0.3 / 2), 1.0, 13 / 6)
        peak = float(plate.stress(np.ones(1), np.full(1, np.pi / 2))[1][0])
        told: list[Any] = [f"{length:g}: {largest_at_hole(plate, length):.5f}" for length in (0.1, 0.25, 0.5)]
        click.echo(f"plate with a hole, b = {outer:g} a: {peak:.5f} at the hole; averages over {', '.join(told)}")
    ring = InflatedRing(RadialSolid(0.5, 0.5, 100.0), 1.0, 1.2, 0.1)
    told = [f"mean hoop stress {ring.mean_hoop:.6f}", f"average over 0.2: {ring.average(0.2):.6f}"]
    click.echo(f"ring [1, 1.2], P = 0.1: {', '.join(told)}")
