"""Two elastic spheres pressed together, beside Hertz's theory for the same force.

    python -m tools.references spheres [--approach 3.68] [--size 1]

A quarter of two half-spheres of radius 50, E = 20000, nu = 0.3, whose planes through the centres approach each other.
These planes are not infinitely far away, so they approach less than Hertz's bodies do under the same force; radius of
contact and peak pressure are compared at the force, which is 5.86e5 at an approach of 3.68. Both come from
integrals of the pressure p per reference area, which Hertz fulfils exactly: ``a^2 = 5/2 int p r^2 / int p``
and ``p0 = 3 F / (2 pi a^2)``. A minute or two.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt

import click
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin
from tools.commands import described
from tools.solutions import solved

RADIUS, YOUNG, POISSON = 50.0, 20000.0, 0.3


@dataclass(frozen=True)
class Pressed:
    """Two spheres in contact: force between them, radius of contact and peak pressure."""

    force: float
    radius: float
    peak: float


def hertz_at(force: float) -> Pressed:
    """Hertz's theory for a force."""
    plane, relative = YOUNG / 2 / (1 - POISSON**2), RADIUS / 2
    radius = (3 * force * relative / (4 * plane)) ** (1 / 3)
    return Pressed(force, radius, 1.5 * force / (pi * radius**2))


def half_sphere(name: str, side: float, size: float) -> Body:
    """A quarter of the half-sphere above (side 1) or below z = 0 that touches the origin."""
    low, high = sorted((0.0, side * RADIUS))
    ball = occ.Sphere((0, 0, side * RADIUS), RADIUS) * occ.Box((0, 0, low), (2 * RADIUS, 2 * RADIUS, high))
    solid = ball.solids[0]
    for face in solid.faces:
        at = face.center
        on = {"x": at.x, "y": at.y, "flat": at.z - side * RADIUS}
        face.name = f"{name}_{next((plane for plane, away in on.items() if abs(away) < 1e-6), 'cap')}"
    for vertex in solid.vertices:
        if abs(vertex.p.z) < 1e-6:
            vertex.maxh = size
    shear, bulk = YOUNG / 2 / (1 + POISSON), YOUNG / 3 / (1 - 2 * POISSON)
    cuts = tuple(f"{name}_{plane}" for plane in ("x", "y", "flat"))
    return Body(solid, MooneyRivlin(c1=shear, c2=0.0, bulk_modulus=bulk), name, cuts)


def pressed(approach: float, size: float, *, order: int = 2) -> Pressed:
    """Press two half-spheres together and measure."""
    bodies = [half_sphere("lower", -1.0, size), half_sphere("upper", 1.0, size)]
    supports = [
        BodySupport(f"{body.name}_{axis}", components=(axis == "x", axis == "y", False))
        for body in bodies
        for axis in "xy"
    ]
    supports += [
        BodySupport(f"{name}_flat", translation=(0.0, 0.0, way * approach / 2), components=(False, False, True))
        for name, way in (("lower", 1.0), ("upper", -1.0))
    ]
    solution = solved(BodyScene(bodies, supports, size=16.0, order=order, levels=1, accuracy=inf))
    if not solution.certified:
        failures = solution.last.measurement.certificate.failures
        raise click.ClickException(f"not certified: {', '.join(failures)}")
    samples = solution.wall_samples(0)
    square = (samples.place[:, :2] ** 2).sum(1)
    force = 4 * solution.last.record.contact_force
    radius = sqrt(2.5 * float(samples.force @ square / samples.force.sum()))
    return Pressed(force, radius, 1.5 * force / (pi * radius**2))


@described(__doc__)
@click.option("--approach", default=3.68, show_default=True, help="Of the planes through the centres.")
@click.option("--size", default=1.0, show_default=True, help="Of elements at the first point of contact.")
@click.option("--order", default=2, show_default=True, help="Of displacement and geometry.")
def command(approach: float, size: float, order: int) -> None:
    """Print radius of contact and peak pressure of two spheres, beside Hertz's at the same force."""
    found = pressed(approach, size, order=order)
    theory = hertz_at(found.force)
    click.echo(f"force {found.force:.5g}")
    for name in ("radius", "peak"):
        mine, exact = getattr(found, name), getattr(theory, name)
        click.echo(f"{name}: {mine:.5g}, Hertz {exact:.5g} ({100 * (mine / exact - 1):+.2f} %)")
