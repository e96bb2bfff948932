"""What a run costs as tissues grow, each figure a ratio within one run, and the aims that they are held to.

    python -m tools.scaling [--only TEXT] [--large]

Each measurement is a process of its own; its figures are kept in `tools/results/scaling.json`, and at the end
`tools/results/scaling.md` lists them beside the aims. `--large` adds the tissue of 500 cells, which takes minutes.

contact
    Share of contact (search, gaps, penalty terms) in a run of the 3x3 and of the 5x7 tissue.
growth
    Seconds of an iteration without the direct solver, and memory, for each unknown, from 9 to 900 cells; with 900,
    130 000 unknowns, a Newton iteration over one factorisation and solve of its matrix.
help
    Seconds on the clock of `ngcell --help`, the smallest of five.
one body
    Processor seconds of a scene of one body over those of the same problem in plain NGSolve.
large
    20x25 cells, order 2, SDDP to a shear of 10 %: minutes on the clock, and memory.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import date
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import click

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "tools" / "results"
#: Iterations that are timed.
ITERATIONS = 4
AIMS = {
    "iteration over factorisation and solve": ("at most", 2.5),
    "the same, with each of the iteration's factorisations counted": ("at most", 2.5),
    "share of contact, 3x3": ("at most", 0.2),
    "share of contact, 5x7": ("at most", 0.2),
    "seconds for each unknown, 100 over 9 cells": ("at most", 1.3),
    "seconds for each unknown, 900 over 9 cells": ("at most", 1.3),
    "memory for each unknown, 900 over 100 cells": ("at most", 1.3),
    "seconds of --help": ("at most", 0.5),
    "one body over plain NGSolve": ("at most", 1.1),
    "minutes of 20x25": ("at most", 15.0),
    "GiB of 20x25": ("at most", 8.0),
}


def tissue(rows: int, cols: int, *, order: int = 2, prescribed_displacement: float = 0.3, **more: Any) -> Any:
    """Return a tissue's case: plates moved along x."""
    import ngcell

    sets = [f"tissue.rows={rows}", f"tissue.cols={cols}", f"mesh.order={order}", "load.levels=1"]
    sets += [
        f"load.displacement=[{prescribed_displacement}, 0.0]",
        *(f"{name}={value}" for name, value in more.items()),
    ]
    return ngcell.read_case("shear-empty", sets)


def peak() -> float:
    """Return the largest resident memory so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def iterated(rows: int, cols: int, order: int) -> dict[str, float]:
    """Time `ITERATIONS` Newton iterations of a released tissue, its proximal term a hundredth of its stiffness."""
    import numpy as np

    from ngcell.build.simulation import Simulation
    from ngcell.solve.minimum import ProximalTerm

    before = peak()
    simulation = Simulation(tissue(rows, cols, order=order))
    minimiser = simulation._minimiser(simulation.released, simulation.longest_step)
    start = simulation.motion.lifting(1.0)
    proximal = ProximalTerm(0.01 * simulation.continuation.scale, start)
    minimiser.most_iterations = 1
    minimiser.minimise(start, proximal)  # what is made once
    clock, effort = simulation.clock.seconds, minimiser.effort.copy()
    clock.clear()
    minimiser.most_iterations = ITERATIONS
    minimiser.minimise(start, proximal)
    spent = minimiser.effort - effort
    matrix, unknowns = minimiser._matrix, simulation.space.unknowns
    values, right = matrix._values.copy(), np.ones(unknowns)
    alone = []
    for _ in range(3):
        started = process_time()
        matrix.factorise(values)
        matrix.solve(right)
        alone.append(process_time() - started)
    rest = clock["pairs and energies"] + clock["assembly"]
    return {
        "cells": rows * cols,
        "unknowns": unknowns,
        "iterations": spent.iterations,
        "factorisations": spent.factorisations,
        "seconds of an iteration": (rest + clock["factorisation"]) / spent.iterations,
        "of it without the direct solver": rest / spent.iterations,
        "factorisation and solve alone": min(alone),
        "MiB": peak() - before,
    }


def contact_share(rows: int, cols: int) -> dict[str, float]:
    """Return what share of a run of the default tissue contact takes."""
    import ngcell
    from ngcell.contact.methods.penalty import PenaltyContact, PenaltySet

    spent = {"contact": 0.0}
    for owner, names in ((PenaltyContact, ("__init__", "pair", "couplings")), (PenaltySet, _methods(PenaltySet))):
        for name in names:
            if hasattr(owner, name):
                setattr(owner, name, _timed(getattr(owner, name), spent))
    started = process_time()
    ngcell.simulate(tissue(rows, cols, order=3, prescribed_displacement=1.0))
    seconds = process_time() - started
    return {"seconds": seconds, "of contact": spent["contact"], "share": spent["contact"] / seconds}


def _methods(owner: type) -> list[str]:
    return [name for name, value in vars(owner).items() if callable(value) and not name.startswith("__")]


def _timed(call: Callable[..., Any], spent: dict[str, float]) -> Callable[..., Any]:
    """Return a function whose seconds are added up, once where such functions call each other."""

    def timed(*arguments: Any, **options: Any) -> Any:
        if spent.get("inside"):
            return call(*arguments, **options)
        started, spent["inside"] = process_time(), 1.0
        try:
            return call(*arguments, **options)
        finally:
            spent["inside"] = 0.0
            spent["contact"] += process_time() - started

    return timed


def one_body() -> dict[str, float]:
    """Return processor seconds of a clamped block pressed down, here and in plain NGSolve."""
    import ngsolve as ngs
    from netgen import occ

    import ngcell
    from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
    from ngcell.scene.bodies import Body, BodyScene, BodySupport

    size, order, down = 0.04, 3, 0.03
    face = occ.Rectangle(1, 1).Face()
    for edge, name in ((occ.Y, "top"), (-occ.Y, "bottom")):
        face.edges.Max(edge).name = name
    face.maxh = size
    material = ngcell.MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=50.0)
    scene = BodyScene(
        [Body(face, material, "block", ())],
        [BodySupport("bottom"), BodySupport("top", translation=(0.0, -down))],
        size=size,
        order=order,
        levels=1,
    )
    ngs.SetNumThreads(1)
    ngcell.simulate(replace(scene, size=0.5))  # imports what is imported when it is first needed
    with _measured() as ours:
        step = ngcell.simulate(scene)[-1]
    with _measured() as plain:
        mesh = ngs.Mesh(occ.OCCGeometry(face, dim=2).GenerateMesh(maxh=size))
        space = ngs.VectorH1(mesh, order=order, dirichlet="bottom|top")
        trial = space.TrialFunction()
        law = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=50.0)
        form = ngs.BilinearForm(space, symmetric=True)
        form += ngs.Variation(law.stored_energy(ngs.Id(2) + ngs.Grad(trial)).Compile() * ngs.dx)
        field = ngs.GridFunction(space)
        field.Set(ngs.CF((0, -down * ngs.y)))
        residual, change = field.vec.CreateVector(), field.vec.CreateVector()
        inverse, iterations = None, 0
        while True:
            form.Apply(field.vec, residual)
            form.AssembleLinearization(field.vec)
            inverse = inverse or form.mat.Inverse(space.FreeDofs(), "sparsecholesky")
            inverse.Update()
            change.data = inverse * residual
            iterations += 1
            field.vec.data -= change
            if abs(ngs.InnerProduct(change, residual)) < 1e-16 or iterations == 30:
                break
        energy = form.Energy(field.vec)
    return {
        "unknowns": float(space.ndof),
        "seconds": ours["seconds"],
        "iterations": float(step.record.iterations),
        "factorisations": float(step.record.factorisations),
        "seconds of plain NGSolve": plain["seconds"],
        "iterations of plain NGSolve": float(iterations),
        "ratio": ours["seconds"] / plain["seconds"],
        "energies apart": abs(step.record.energy / energy - 1),
    }


@contextmanager
def _measured() -> Iterator[dict[str, float]]:
    found: dict[str, float] = {}
    started = process_time()
    yield found
    found["seconds"] = process_time() - started


def seconds_of_help() -> dict[str, float]:
    """Return the smallest of five times that `ngcell --help` takes on the clock."""
    taken = []
    for _ in range(5):
        started = perf_counter()
        subprocess.run([sys.executable, "-m", "ngcell", "--help"], check=True, capture_output=True, cwd=ROOT)
        taken.append(perf_counter() - started)
    return {"seconds": min(taken)}


def large() -> dict[str, float]:
    """Run 500 cells to a shear of a tenth of the height."""
    from ngcell.build.simulation import Simulation

    started = perf_counter(), process_time()
    height = 1.5 * 19 + 2
    simulation = Simulation(tissue(20, 25, prescribed_displacement=0.1 * height))
    steps = list(simulation.accepted_steps())
    return {
        "unknowns": float(simulation.space.unknowns),
        "minutes": (perf_counter() - started[0]) / 60,
        "processor minutes": (process_time() - started[1]) / 60,
        "GiB": peak() / 1024,
        "iterations": float(sum(step.record.iterations for step in steps)),
        "factorisations": float(sum(step.record.factorisations for step in steps)),
        "certified": float(all(step.record.certified for step in steps)),
        **{f"{name} s": value for name, value in simulation.clock.seconds.items()},
    }


MEASUREMENTS: dict[str, Callable[[], dict[str, float]]] = {
    "help": seconds_of_help,
    "one body": one_body,
    "contact 3x3": lambda: contact_share(3, 3),
    "contact 5x7": lambda: contact_share(5, 7),
    "growth 3x3": lambda: iterated(3, 3, 2),
    "growth 10x10": lambda: iterated(10, 10, 2),
    "growth 30x30": lambda: iterated(30, 30, 2),
    "large": large,
}


def ratios(found: dict[str, dict[str, float]]) -> dict[str, float]:
    """Return the figures that aims are about, as far as they were measured."""
    figures = {}
    if "growth 30x30" in found:
        run = found["growth 30x30"]
        alone = run["factorisation and solve alone"]
        figures["iteration over factorisation and solve"] = run["seconds of an iteration"] / alone
        rounds = run["factorisations"] / run["iterations"]
        figures["the same, with each of the iteration's factorisations counted"] = run["seconds of an iteration"] / (
            rounds * alone
        )
    for size in ("3x3", "5x7"):
        if f"contact {size}" in found:
            figures[f"share of contact, {size}"] = found[f"contact {size}"]["share"]
    for size, cells in (("10x10", 100), ("30x30", 900)):
        if {"growth 3x3", f"growth {size}"} <= found.keys():
            small, big, seconds = found["growth 3x3"], found[f"growth {size}"], "of it without the direct solver"
            figures[f"seconds for each unknown, {cells} over 9 cells"] = (
                big[seconds] / big["unknowns"] / (small[seconds] / small["unknowns"])
            )
    if {"growth 10x10", "growth 30x30"} <= found.keys():
        middle, big = found["growth 10x10"], found["growth 30x30"]
        figures["memory for each unknown, 900 over 100 cells"] = (
            big["MiB"] / big["unknowns"] / (middle["MiB"] / middle["unknowns"])
        )
    if "help" in found:
        figures["seconds of --help"] = found["help"]["seconds"]
    if "one body" in found:
        figures["one body over plain NGSolve"] = found["one body"]["ratio"]
    if "large" in found:
        figures["minutes of 20x25"] = found["large"]["minutes"]
        figures["GiB of 20x25"] = found["large"]["GiB"]
    return figures


def report(found: dict[str, dict[str, float]], path: Path) -> None:
    """Write figures beside aims, and what they follow from."""
    figures = ratios(found)
    lines = [
        f"# What runs cost\n\n{date.today()}, {os.cpu_count()} cores. `python -m tools.scaling --large` makes this.\n"
    ]
    lines += ["| figure | measured | aim | |", "|---|---|---|---|"]
    for name, (word, aim) in AIMS.items():
        verdict = "not measured" if name not in figures else "held" if figures[name] <= aim else "missed"
        shown = f"{figures[name]:.3g}" if name in figures else ""
        lines.append(f"| {name} | {shown} | {word} {aim:g} | {verdict} |")
    for name, numbers in found.items():
        lines += ["", f"## {name}", "", "| " + " | ".join(numbers) + " |", "|" + "---|" * len(numbers)]
        lines.append("| " + " | ".join(f"{value:.4g}" for value in numbers.values()) + " |")
    path.write_text("\n".join([*lines, ""]))


@click.command(help=__doc__.split("\n")[0])
@click.option("--only", default="", help="Measurements whose name has this text.")
@click.option("--large", "with_large", is_flag=True, help="Run the tissue of 500 cells, too.")
@click.option("--one", hidden=True)
def main(only: str, with_large: bool, one: str | None) -> None:
    """Measure, and report."""
    if one:
        click.echo(json.dumps(MEASUREMENTS[one]()))
        return
    file = RESULTS / "scaling.json"
    found = json.loads(file.read_text()) if file.exists() else {}
    for name in MEASUREMENTS:
        if only in name and (name != "large" or with_large):
            command = [sys.executable, "-m", "tools.scaling", "--one", name]
            here = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
            run = subprocess.run(command, cwd=ROOT, env=here, check=True, capture_output=True, text=True)
            found[name] = json.loads(run.stdout.splitlines()[-1])
            click.echo(f"{name}: {found[name]}", err=True)
    found = {name: found[name] for name in MEASUREMENTS if name in found}
    file.write_text(json.dumps(found, indent=1) + "\n")
    report(found, file.with_suffix(".md"))


if __name__ == "__main__":
    main()
