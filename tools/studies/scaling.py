"""What a run costs as tissues grow, and the aims that this is held to.

    python -m tools.studies scaling [--only TEXT] [--large]

Each figure is a ratio within one run. Each measurement is a process of its own; its figures are kept in
`tools/results/scaling.json`, and at the end `tools/results/scaling.md` lists them beside the aims. `--large` adds the
tissue of 500 cells, which takes minutes.

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
from datetime import date
from pathlib import Path

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import found_by
from tools.studies.measurements import MEASUREMENTS

AIMS = {
    "iteration over factorisation and solve": 2.5,
    "the same, with each of the iteration's factorisations counted": 2.5,
    "share of contact, 3x3": 0.2,
    "share of contact, 5x7": 0.2,
    "seconds for each unknown, 100 over 9 cells": 1.3,
    "seconds for each unknown, 900 over 9 cells": 1.3,
    "memory for each unknown, 900 over 100 cells": 1.3,
    "seconds of --help": 0.5,
    "one body over plain NGSolve": 1.1,
    "minutes of 20x25": 15.0,
    "GiB of 20x25": 8.0,
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
    made = f"{date.today()}, {os.cpu_count()} cores. `python -m tools.studies scaling --large` makes this."
    lines = [f"# What runs cost\n\n{made}\n"]
    lines.append(tables.markdown(("figure", "measured", "aim", ""), [_beside(name, figures) for name in AIMS]))
    for name, numbers in found.items():
        values = [f"{value:.4g}" for value in numbers.values()]
        lines += ["", f"## {name}", "", tables.markdown(list(numbers), [values])]
    path.write_text("\n".join([*lines, ""]))


def _beside(name: str, figures: dict[str, float]) -> tuple[str, ...]:
    """Return a figure beside its aim."""
    aim = f"at most {AIMS[name]:g}"
    if name not in figures:
        return name, "", aim, "not measured"
    return name, f"{figures[name]:.3g}", aim, "held" if figures[name] <= AIMS[name] else "missed"


@described(__doc__)
@click.option("--only", default="", help="Measurements whose name has this text.")
@click.option("--large", "with_large", is_flag=True, help="Run the tissue of 500 cells, too.")
@click.option("--one", hidden=True)
def command(only: str, with_large: bool, one: str | None) -> None:
    """Measure, and report."""
    if one:
        click.echo(json.dumps(MEASUREMENTS[one]()))
        return
    file = RESULTS / "scaling.json"
    found = json.loads(file.read_text()) if file.exists() else {}
    for name in MEASUREMENTS:
        if only in name and (name != "large" or with_large):
            found[name] = found_by("tools.studies", "scaling", "--one", name)
            click.echo(f"{name}: {found[name]}", err=True)
    found = {name: found[name] for name in MEASUREMENTS if name in found}
    file.write_text(json.dumps(found, indent=1) + "\n")
    report(found, file.with_suffix(".md"))
