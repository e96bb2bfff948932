"""How accurate contact is, and at what price: rings with exact answers, by method, order and size of elements.

    python -m tools.contact_study [--quick] [--jobs 1] [--timeout 600] [--only TEXT]

Quarters of two rings, one in the other, with meshes that do not match, against `tools.radial` at kappa/mu = 1000:

press-fit, tight-fit
    K2: an inner ring [0.5, 1.0] in one that is narrower, [0.9, 1.5] or [0.8, 1.5].
pulled
    K3: an outer ring [1.0, 1.5] whose rim is pulled to 1.6; the rings part.
below, touch, above
    K4: an inner ring [0.5, 1.0] that a pressure of 0.2, of first touch, or of 0.6 drives towards [1.1, 1.6].

Each run is a process of its own; its row is appended to `tools/results/contact-study.csv`, and a run that has its row
there is not repeated; the last column tells which sources made it. The pressure between the rings is read from the
forces on the outer ring's planes of symmetry. At the end the table of errors and the rates at which they fall go to
`contact-study.md` beside it, and two figures, error over seconds and rates, to `docs`. `--quick` takes two problems and
two sizes, and writes no figures.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import click

from tools import tables
from tools.settings import sources

ROOT = Path(__file__).resolve().parent.parent
RESULTS, DOCS = ROOT / "tools" / "results", ROOT / "docs"

KAPPA, C1, C2 = 1000.0, 0.5, 0.5
#: Bore and rim of the outer ring, the radius that its rim is pulled to, and the pressure in the inner ring [0.5, 1.0].
PROBLEMS: dict[str, tuple[float, float, float | None, float | None]] = {
    "press-fit": (0.9, 1.5, None, None),
    "tight-fit": (0.8, 1.5, None, None),
    "pulled": (1.0, 1.5, 1.6, None),
    "below": (1.1, 1.6, None, 0.2),
    "touch": (1.1, 1.6, None, 0.350737),
    "above": (1.1, 1.6, None, 0.6),
}
METHODS = {"mortar": None, "penalty": 1.0, "penalty x10": 10.0}
SIZES, ORDERS = (0.25, 0.125, 0.0625), (1, 2, 3)
#: Elements of the outer ring are smaller by this factor, so that meshes do not match.
MISMATCH = 0.8
#: Quantities with an exact value. Stresses are in units of the shear modulus.
QUANTITIES = ("bore", "interface", "gap", "pressure")


@dataclass(frozen=True)
class Run:
    """One run of the study."""

    problem: str
    method: str
    order: int
    size: float

    @property
    def label(self) -> str:
        """The row's key."""
        return f"{self.problem}, {self.method}, order {self.order}, size {self.size}"


def grid(quick: bool) -> Iterator[Run]:
    """All runs, the cheap ones first."""
    problems = ("press-fit", "above") if quick else tuple(PROBLEMS)
    sizes = SIZES[:2] if quick else SIZES
    for size, order, problem, method in product(sizes, ORDERS, problems, METHODS):
        yield Run(problem, method, order, size)


def exact(problem: str) -> dict[str, float]:
    """Return the exact values, from one dimension."""
    from tools import radial

    bore, rim, pulled, pressure = PROBLEMS[problem]
    solid = radial.RadialSolid(C1, C2, KAPPA)
    pair = radial.Ring(solid, 0.5, 1.0), radial.Ring(solid, bore, rim)
    if pulled is not None:
        state = radial.pulled_apart(*pair, pulled)
    elif pressure is not None:
        state = radial.closing(*pair, pressure)
    else:
        state = radial.press_fit(*pair)
    values = map(float, (state.inside.inner, state.inside.outer, state.gap, state.contact_pressure))
    return dict(zip(QUANTITIES, values, strict=True))


def solved(run: Run) -> dict[str, float]:
    """Solve, and return quantities and effort; the seconds are those of mesh, assembly and solution."""
    import time

    import ngsolve
    import numpy as np

    from ngcell.simulation import Simulation

    ngsolve.SetNumThreads(1)
    start = time.process_time()
    simulation = Simulation(scene(run))
    *_, final = simulation.walk()
    seconds = time.process_time() - start - simulation.clock.seconds["measuring"]
    space = simulation.space

    def radius(boundary: str) -> float:
        unknowns = space.region_unknowns(boundary)
        vertices = unknowns[space.one[unknowns] > 0]
        at = space.rest + final.displacement.reshape(2, -1)
        return float(np.linalg.norm(at[:, vertices], axis=0).mean())

    sides = {name: simulation.motion.resultant(final.measurement.reaction, f"outer-{name}") for name in "xy"}
    # The hoop force of the outer ring bears the pressure between the rings, unless its rim is held.
    hoop = 0.0 if PROBLEMS[run.problem][2] is not None else (sides["y"][0] + sides["x"][1]) / 2
    interface, outer_bore = radius("inner-rim"), radius("outer-bore")
    return {
        "bore": radius("inner-bore"),
        "interface": interface,
        "gap": outer_bore - interface,
        "pressure": -float(hoop) / min(interface, outer_bore),
        "unknowns": space.unknowns,
        "iterations": final.record.iterations,
        "factorisations": final.record.factorisations,
        "seconds": round(seconds, 3),
        "certified": final.record.certified,
    }


def scene(run: Run) -> Any:
    """Return the scene of a run."""
    from ngcell.scene import MooneyRivlin, Mortar, Penalty
    from ngcell.scene.bodies import Body, BodyScene, BodySupport, Pressure

    bore, rim, pulled, pressure = PROBLEMS[run.problem]
    material, stiffness = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA), METHODS[run.method]
    outer_size = MISMATCH * run.size
    bodies = [
        Body(quarter(0.5, 1.0, "inner", run.size), material, "inner", ("inner-x", "inner-y")),
        Body(quarter(bore, rim, "outer", outer_size), material, "outer", ("outer-x", "outer-y")),
    ]
    supports = []
    if pulled is not None:
        growth = pulled / rim - 1
        supports.append(BodySupport("outer-rim", gradient=((growth, 0.0), (0.0, growth))))
    for name in ("inner", "outer"):
        supports.append(BodySupport(f"{name}-x", components=(False, True)))
        supports.append(BodySupport(f"{name}-y", components=(True, False)))
    return BodyScene(
        bodies,
        supports,
        size=run.size,
        order=run.order,
        levels=1,
        contact=Mortar() if stiffness is None else Penalty(stiffness=stiffness),
        loads=[] if pressure is None else [Pressure("inner-bore", pressure)],
    )


def quarter(bore: float, rim: float, name: str, size: float) -> Any:
    """Return a quarter of a ring in the first quadrant."""
    from netgen import occ

    ring = occ.Circle((0.0, 0.0), rim).Face() - occ.Circle((0.0, 0.0), bore).Face()
    face = (ring * occ.Rectangle(2 * rim, 2 * rim).Face()).faces[0]
    for edge in face.edges:
        ends = abs(edge.start.x) + abs(edge.end.x), abs(edge.start.y) + abs(edge.end.y)
        if min(ends) < 1e-9:
            edge.name = f"{name}-y" if ends[0] < ends[1] else f"{name}-x"
        else:
            edge.name = f"{name}-rim" if sum(ends) > bore + rim else f"{name}-bore"
    face.maxh = size
    return face


def row(run: Run, timeout: float) -> dict[str, Any]:
    """Run in a process of its own and return the row."""
    command = [sys.executable, "-m", "tools.contact_study", "--one", json.dumps(asdict(run))]
    outcome, found, version = "converged", {}, sources()
    try:
        ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False)
        if ended.returncode:
            outcome = (ended.stderr.strip().splitlines() or ["no log"])[-1].partition(";")[0]
        else:
            found = json.loads(ended.stdout.splitlines()[-1])
    except subprocess.TimeoutExpired:
        outcome = "timeout"
    return {"run": run.label, **asdict(run), "outcome": outcome, **found, "code": version}


COLUMNS = (
    *("run", "problem", "method", "order", "size", "outcome", *QUANTITIES),
    *("unknowns", "iterations", "factorisations", "seconds", "certified", "code"),
)


def rows_in(table: Path) -> dict[str, dict[str, Any]]:
    """Return the rows of a table by key."""
    return {line["run"]: line for line in tables.read(table)}


@click.command(help=__doc__.split("\n")[0])
@click.option("--quick", is_flag=True, help="Two problems, two sizes, no figures.")
@click.option("--jobs", default=1, show_default=True, help="Processes at a time.")
@click.option("--timeout", default=600.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Take the runs whose key contains this text.")
@click.option("--one", hidden=True, help="Solve this run here and print what was found.")
def main(quick: bool, jobs: int, timeout: float, only: str, one: str | None) -> None:
    if one is not None:
        click.echo(json.dumps(solved(Run(**json.loads(one)))))
        return
    from tools.contact_report import report

    RESULTS.mkdir(parents=True, exist_ok=True)
    table = RESULTS / "contact-study.csv"
    done = rows_in(table)
    runs = list(grid(quick))
    todo = [run for run in runs if run.label not in done and only in run.label]
    with ThreadPoolExecutor(jobs) as pool:
        for line in pool.map(lambda run: row(run, timeout), todo):
            tables.append(table, COLUMNS, [line])
            click.echo(f"{line.get('seconds', ''):>8} s  {line['run']}  {line['outcome']}", err=True)
    done = rows_in(table)
    rows = [done[run.label] for run in runs if run.label in done]
    report(rows, RESULTS / "contact-study.md", None if quick else DOCS, {name: exact(name) for name in PROBLEMS})


if __name__ == "__main__":
    main()
