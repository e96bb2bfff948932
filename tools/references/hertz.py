"""A half-cylinder on a block, and two half-cylinders, pressed together, beside Hertz's theory.

    python -m tools.references hertz [--method mortar] [--figure docs/hertz.png]

Prints half-width, peak and the elements under pressure, at the line load of the shipped cases and at smaller ones, and
draws the pressures over the half-ellipse. Hertz's theory is one of small strain, in which lengths at rest and deformed
are the same. Where it is compared with finite strain, that makes a difference of the order of the strain, a / R, and
falls with the load; what is left of the deviation as the load falls is that of the mesh. A half-width is known to an
element, which is twice its value over the number of elements.

Ends with 1 where, at the cases' load, half-width or peak of the nominal pressure, that per reference length, is
further than 2 % from theory, or fewer than ten elements are in contact.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path
from time import process_time

import click
import numpy as np
from matplotlib.figure import Figure

import ngcell
from ngcell import BodyCase
from tools.commands import described
from tools.places import DOCS
from tools.solutions import solved

FIGURE = DOCS / "hertz.png"
#: E and nu of all bodies, radius of the cylinders, and the line load on the whole cylinder.
YOUNG, POISSON, RADIUS, LOAD = 200.0, 0.3, 8.0, 10.0
#: Case, radius that stands for the pair, and the walls.
PROBLEMS = {
    "half-cylinder": ("hertz-half-cylinder", RADIUS, ("cylinder_outer", "block_top")),
    "cylinders": ("hertz-cylinders", RADIUS / 2, ("cylinder_outer", "base_outer")),
}
SHARES = (1.0, 0.5, 0.25)
TOLERANCE, FEWEST = 0.02, 10
#: Share of the peak from which on a wall counts as pressed.
PRESSED = 1e-2


@dataclass(frozen=True, eq=False)
class Profile:
    """Pressures along a wall, and what Hertz says of them.

    Attributes
    ----------
    problem : str
        half-cylinder, on a block, or cylinders, two halves.
    share : float
        Share of the line load that acts.
    width, peak : float
        Hertz's half-width [length] and peak [stress].
    at, nominal : array of float, shape (points,)
        Distance from the middle [length] and pressure [stress], both at rest.
    at_deformed, true : array of float, shape (points,)
        The same, deformed.
    length, length_deformed : array of float, shape (points,)
        Length that each point stands for [length].
    elements : int
        Edges of the wall under pressure, on both sides of the middle.
    seconds : float
        Processor seconds of the solution.
    """

    problem: str
    share: float
    width: float
    peak: float
    at: np.ndarray
    nominal: np.ndarray
    at_deformed: np.ndarray
    true: np.ndarray
    length: np.ndarray
    length_deformed: np.ndarray
    elements: int
    seconds: float

    def found(self, kind: str) -> tuple[float, float]:
        """Return half-width and peak, nominal or true."""
        pressure, length = (self.nominal, self.length) if kind == "nominal" else (self.true, self.length_deformed)
        return float(length[pressure > PRESSED * pressure.max()].sum()), float(pressure.max())

    def deviations(self, kind: str) -> tuple[float, float]:
        """Return the relative deviations of half-width and peak from theory."""
        width, peak = self.found(kind)
        return width / self.width - 1, peak / self.peak - 1


def theory(radius: float, load: float) -> tuple[float, float]:
    """Return Hertz's half-width and peak of two bodies with the same constants under a line load."""
    modulus = YOUNG / (1 - POISSON**2) / 2
    return sqrt(4 * load * radius / (pi * modulus)), sqrt(load * modulus / (pi * radius))


def profile(problem: str, share: float, method: str) -> Profile:
    """Solve a case at a share of its load, with elements that shrink with the half-width."""
    name, radius, (wall, _) = PROBLEMS[problem]
    case = ngcell.read_case(name, [f"levels=[{share}]", f"contact.kind={method}", "accuracy=inf"])
    assert isinstance(case, BodyCase)
    zones = tuple(
        zone.model_copy(update={"within": zone.within * sqrt(share), "size": zone.size * sqrt(share)})
        for zone in case.mesh.refine
    )
    mesh = case.mesh.model_copy(update={"refine": zones})
    case = case.model_copy(update={"mesh": mesh, "expected": ()})
    started = process_time()
    solution = solved(case)
    seconds, found = process_time() - started, solution.wall_pressures(wall)
    pressed = np.unique(found.edge[found.nominal > PRESSED * found.nominal.max()])
    order = np.argsort(found.place[:, 0])
    return Profile(
        problem,
        share,
        *theory(radius, share * LOAD),
        at=found.place[order, 0],
        nominal=found.nominal[order],
        at_deformed=found.place_deformed[order, 0],
        true=(found.nominal * found.length / found.length_deformed)[order],
        length=found.length[order],
        length_deformed=found.length_deformed[order],
        elements=2 * len(pressed),
        seconds=seconds,
    )


def draw(profiles: list[Profile], path: Path) -> None:
    """Draw nominal and true pressures at the cases' load over the half-ellipse."""
    shown = [each for each in profiles if each.share == 1]
    figure = Figure(figsize=(10, 3.8), layout="constrained")
    panels = figure.subplots(1, len(shown), squeeze=False)
    for axes, each in zip(panels[0], shown, strict=True):
        near = each.at < 1.3 * each.width
        x = np.linspace(0, each.width, 400)
        axes.plot(x, each.peak * np.sqrt(1 - (x / each.width) ** 2), "k-", lw=1, label="Hertz")
        axes.plot(each.at[near][::7], each.nominal[near][::7], "C0o", ms=3, label="per reference length")
        axes.plot(each.at_deformed[near][::7], each.true[near][::7], "C1.", ms=3, label="per deformed length")
        width, peak = each.deviations("nominal")
        axes.set_title(f"{each.problem}: a {width:+.2%}, p0 {peak:+.2%}, {each.elements} elements")
        axes.set(xlabel="distance from the middle", ylabel="contact pressure")
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=150)


@described(__doc__)
@click.option("--method", type=click.Choice(["mortar", "penalty"]), default="mortar", show_default=True)
@click.option("--figure", type=click.Path(path_type=Path), default=FIGURE, show_default="docs/hertz.png")
def command(method: str, figure: Path) -> None:
    """Solve, tell and draw."""
    profiles = []
    click.echo("      problem  load  a Hertz   p0 Hertz  nominal: a       p0   true: a       p0  elements  seconds")
    for problem in PROBLEMS:
        for share in SHARES:
            each = profile(problem, share, method)
            profiles.append(each)
            deviations = "".join(f"{d:+9.2%}" for kind in ("nominal", "true") for d in each.deviations(kind))
            click.echo(
                f"{problem:>13} {share * LOAD:5g} {each.width:8.5f} {each.peak:10.5f} {deviations:>38}"
                f"{each.elements:>10}{each.seconds:9.1f}"
            )
    draw(profiles, figure)
    click.echo(f"drawn: {figure}")
    at_load = [each for each in profiles if each.share == 1]
    missed = [each for each in at_load if max(map(abs, each.deviations("nominal"))) > TOLERANCE]
    few = [each for each in at_load if each.elements < FEWEST]
    sys.exit(bool(missed or few))
