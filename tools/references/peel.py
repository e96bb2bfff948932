"""A double-cantilever strip, bonded along most of its length, is peeled apart at one end.

    python -m tools.references peel [--size 0.1] [--steps 60] [--out FILE]

By beam theory two arms of height h, whose ends a force P pulls apart by 2 d, have a crack whose length a is that
of ``d = P a^3 / (3 E I)``, and release the energy ``G = P^2 a^2 / (E I)`` for each unit of crack, with
``I = h^3 / 12`` and the modulus E of plane strain. The length that follows from force and opening includes what the
arms give way in front of the crack. Bonds break at G = separation energy, so the peel has to go on at that G, whatever
a is. Rows go to `tools/results/peel.csv`.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

import click
import numpy as np
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, Cohesion, MooneyRivlin
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.solutions import Solution

TABLE = RESULTS / "peel.csv"
LENGTH, HEIGHT, NOTCH = 6.0, 0.1, 2.0
#: Share of an end by which it is held.
GRIP = 0.1
#: Stiffness of the material at rest: shear and bulk modulus, and from them the modulus of plane strain.
SHEAR, BULK = 1.0, 5.0 / 3.0
POISSON = (3 * BULK - 2 * SHEAR) / (2 * (3 * BULK + SHEAR))
MODULUS = 2 * SHEAR / (1 - POISSON)
BENDING = MODULUS * HEIGHT**3 / 12


def arm(name: str, bottom: float, bonded: str) -> Body:
    """Return an arm; its side towards the other one is a wall behind the notch only.

    Its end is held by a small piece at mid-height: held as a whole, an end that turns would have to stretch.
    """
    grip = GRIP * HEIGHT
    rest = (HEIGHT - grip) / 2
    face = occ.MoveTo(0.0, bottom).Line(NOTCH).Line(LENGTH - NOTCH).Rotate(90).Line(HEIGHT).Rotate(90)
    face = face.Line(LENGTH - NOTCH).Line(NOTCH).Rotate(90).Line(rest).Line(grip).Close().Face()
    untouched = []
    for edge in face.edges:
        x, y = edge.center.x, edge.center.y
        if x < 1e-9:
            side = "grip" if abs(y - bottom - HEIGHT / 2) < grip / 4 else "end"
        elif x > LENGTH - 1e-9:
            side = "far"
        else:
            side = ("bottom" if y < bottom + HEIGHT / 2 else "top") + ("_notch" if x < NOTCH else "")
        edge.name = f"{name}_{side}"
        if side != bonded:
            untouched.append(edge.name)
    return Body(face, MooneyRivlin(c1=SHEAR / 2, c2=SHEAR / 2, bulk_modulus=BULK), name, tuple(untouched))


def strip(*, toughness: float, zone: float, opening: float, size: float, order: int, steps: int) -> BodyScene:
    """Return the strip.

    Parameters
    ----------
    toughness : float
        Separation energy [stress * length].
    zone : float
        Length over which an arm on whole bonds decays, that of a beam on penalty terms [length].
    opening : float
        How far the ends are pulled apart [length].
    size, order, steps : float, int, int
        Of elements, and the smallest number of steps.
    """
    stiffness = 2 * BENDING / zone**4
    strength = np.sqrt(stiffness * toughness) / np.e
    return BodyScene(
        (arm("lower", -HEIGHT, "top"), arm("upper", 0.0, "bottom")),
        (
            BodySupport("lower_far"),
            BodySupport("upper_far"),
            BodySupport("lower_grip", translation=(0.0, -opening / 2), components=(False, True)),
            BodySupport("upper_grip", translation=(0.0, opening / 2), components=(False, True)),
        ),
        size=size,
        order=order,
        levels=1,
        steps=steps,
        cohesion=Cohesion(strength=float(strength), energy=toughness),
        accuracy=inf,
    )


def peeled(scene: BodyScene) -> Iterator[dict[str, float]]:
    """Peel, and yield a row a step while the crack grows: from the first broken bond on."""
    solution = Solution(scene)
    opening = 2 * scene.supports[-1].translation[1]
    toughness = scene.cohesion.energy
    for step in solution.follow():
        force = float(solution.resultant("upper_grip")[1])
        apart = step.record.load_factor * opening
        crack = (3 * BENDING * apart / 2 / force) ** (1 / 3)
        yield {
            "opening": apart,
            "force": force,
            "crack_of_compliance": crack,
            "crack_of_broken_bonds": NOTCH + (1 - step.record.bonded_share) * (LENGTH - NOTCH),
            "release_over_toughness": (force * crack) ** 2 / BENDING / toughness,
            "stored_energy": step.record.energy,
            "separation_energy": step.record.separation_energy,
            "dissipation": step.record.dissipation,
            "certified": float(step.record.certified),
        }


@described(__doc__)
@click.option("--toughness", default=5.5e-7, show_default=True)
@click.option("--zone", default=0.2, show_default=True)
@click.option("--opening", default=0.5, show_default=True)
@click.option("--size", default=0.1, show_default=True)
@click.option("--order", default=3, show_default=True)
@click.option("--steps", default=40, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=TABLE, show_default="tools/results/peel.csv")
def command(out: Path, **numbers: Any) -> None:
    """Peel, write the table and show it."""
    rows = []
    for row in peeled(strip(**numbers)):
        rows.append(row)
        click.echo(
            f"opening {row['opening']:.4f}  force {row['force']:.4e}  crack {row['crack_of_compliance']:.3f}, "
            f"bonds broken up to {row['crack_of_broken_bonds']:.3f}  G / toughness {row['release_over_toughness']:.4f}"
        )
    tables.write(out, list(rows[0]), [{name: f"{value:.6g}" for name, value in row.items()} for row in rows])
