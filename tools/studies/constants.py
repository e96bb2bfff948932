"""What results depend on: each of the solver's own numbers is made smaller and larger, on four scenes.

    python -m tools.studies constants [--only TEXT] [--scene empty]

Each number is put in place of the package's, a 3x3 tissue is run again at accuracy inf, or at 0.01 if it counts there
only, and what changes is told relative to the run with all numbers as they are: energy and plate force, and the ratio
of iterations. Numbers that count among many cells only are changed on two tissues of 6x6 cells at accuracy 0.1. Tables
are kept in `tools/results/constants.csv` and `.md`, rows from the moment on that they are found: those of the present
version are not run again. A run of some numbers or scenes is shown and not kept.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import click

import ngcell
from ngcell.build.options import Options
from ngcell.errors import NgcellError
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import sources
from tools.studies.numbers import changed, usual

SCENES = {
    "empty": ["load.levels=1"],
    "pressurised": ["load.levels=1", 'lumen.kind="pressure"', "lumen.pressure=0.0025"],
    "filled": ["load.levels=1", "load.displacement=[0.4, 0.0]", 'lumen.kind="inclusion"',
               'lumen.material.kind="mooney-rivlin"', "lumen.material.c1=0.01", "lumen.material.c2=0.01",
               "lumen.material.bulk_modulus=1.0"],
    "mortar": ["load.levels=1", "load.displacement=[0.4, 0.0]", 'contact.kind="mortar"'],
}  # fmt: skip
#: The package's own numbers, and the values in place of them.
CHANGES: dict[str, tuple[float, ...]] = {
    "solver.continuation.first": (1e2, 1e4),
    "solver.continuation.last": (1e-8, 1e-10),
    "solver.continuation.enough": (1e-6, 1e-8),
    "solver.continuation.narrowest": (0.25, 1.0),
    "solver.continuation.widest": (0.5, 2.0),
    "solver.minimiser.last_digit": (1e-6, 1e-4),
    "solver.minimiser.cheap_at_last": (1e-4, 0.01),
    "solver.continuation.stiffen_at": (1e-6, 1e-4),
    "solver.continuation.on_the_way": (1e-3, 0.1),
    "solver.continuation.at_the_end": (1e-14, 1e-10),
    "solver.continuation.update": (0.05, 0.2),
    "solver.continuation.foreseen": (1e-6, 1e-4),
    "solver.continuation.cycling": (100, 400),
    "solver.continuation.slow": (0.05, 0.25),
    "solver.minimiser.inner.most_rounds": (4, 16),
    "solver.minimiser.inner.worthwhile_gain": (0.15, 0.6),
    "solver.minimiser.inner.lost": (1e4, 1e8),
    "solver.minimiser.inner.most_updates": (50, 200),
    "solver.minimiser.poor": (1e-5, 1e-3),
    "solver.minimiser.fair": (0.1, 0.5),
    "solver.minimiser.raise_by": (4.0, 16.0),
    "solver.minimiser.lower_by": (0.05, 0.2),
    "solver.minimiser.short": (0.03, 0.3),
    "solver.minimiser.felt": (0.05, 0.2),
    "solver.minimiser.unfelt": (1e-5, 1e-3),
    "solver.minimiser.stalled": (1e-13, 1e-11),
    "solver.minimiser.idle": (3, 10),
    "solver.stability.as_low": (0.8, 0.95),
    "solver.stability.most_modes": (1, 6),
    "contact.path_multiple": (0.5, 2.0),
    "contact.stage_factor": (5.0, 20.0),
    "contact.mortar_multiple": (1.0, 10.0),
    "contact.between": (1.5, 4.0),
    "contact.soft": (0.01, 0.02),
    "contact.stored": (0.005, 0.02),
    "contact.allowed": (1.25e-4, 5e-4),
    "contact.covered": (0.001, 0.1),
    "contact.facing": (-0.9, -0.7),
}
#: The same, of numbers that count with a finite accuracy only.
WITHIN_ACCURACY: dict[str, tuple[float, ...]] = {
    "solver.minimiser.cheap": (1e-3, 0.1),
    "solver.minimiser.inner.least_gain": (0.001, 0.1),
    "solver.minimiser.inner.most_settled": (20, 80),
    "solver.minimiser.sure": (1.0, 100.0),
    "solver.continuation.recentred": (1e-5, 1e-3),
    "solver.continuation.resting": (1e-4, 1e-2),
    "solver.continuation.leading": (0.002, 0.2),
    "solver.continuation.sufficient_to_lead": (0.01, 0.04),
    "solver.continuation.sufficient_of_accuracy": (0.02, 0.1),
    "solver.continuation.felt_of_accuracy": (0.02, 0.1),
    "solver.continuation.allowed_of_accuracy": (0.03, 0.09),
    "solver.continuation.idle": (0.8, 0.95),
    "solver.continuation.hardly_strained": (1e-6, 1e-4),
    "solver.continuation.handover": (1.0, 10.0),
    "solver.continuation.handover_update": (0.003, 0.1),
    "contact.stored_before": (0.03, 0.3),
}
#: The same, of numbers that count among many cells only.
AMONG_MANY: dict[str, tuple[float, ...]] = {
    "solver.minimiser.worthwhile": (5.0, 20.0),
    "solver.minimiser.inner.coarse.fewest": (37,),
    "solver.minimiser.inner.coarse.modes": (4, 12),
    "solver.minimiser.inner.coarse.first_steps": (1, 6),
    "solver.minimiser.inner.coarse.most_rounds": (10, 100),
    "solver.minimiser.inner.coarse.worthwhile_gain": (0.02, 0.1),
    "solver.continuation.allowed_to_lead": (3e-4, 3e-3),
    "solver.continuation.most_led": (5, 20),
    "solver.continuation.led_at_most": (0.25, 0.75),
}


@dataclass(frozen=True)
class Group:
    """Numbers that are changed on the same tissues.

    Attributes
    ----------
    changes : dict
        Values in place of each number.
    accuracy : str
        Accuracy of the case.
    settings : tuple of str
        Further settings.
    scenes : tuple of str
        The scenes of `SCENES`.
    """

    changes: dict[str, tuple[float, ...]]
    accuracy: str = "inf"
    settings: tuple[str, ...] = ()
    scenes: tuple[str, ...] = tuple(SCENES)


TABLE, REPORT = RESULTS / "constants.csv", RESULTS / "constants.md"
#: What is told of each scene.
_MEASURED = ("energy", "force", "iterations")
_TOLD = (*_MEASURED, "certified")
COLUMNS = ("number", "usual", "here", *(f"{scene}: {what}" for scene in SCENES for what in _TOLD), "code")

GROUPS = (
    Group(CHANGES),
    Group(WITHIN_ACCURACY, "0.01"),
    Group(AMONG_MANY, "0.1", ("tissue.rows=6", "tissue.cols=6"), ("empty", "pressurised")),
)


def run(scene: str, options: Options | None = None, group: Group = GROUPS[0]) -> dict[str, float]:
    """Return energy, plate force and iterations of a scene; nothing if it found no equilibrium."""
    settings = [*SCENES[scene], *group.settings, f"accuracy={group.accuracy}"]
    try:
        *_, step = ngcell.simulate(ngcell.read_case("shear-empty-3x3", settings), options=options)
    except NgcellError:
        return {}
    record = step.record
    return {
        "energy": record.energy,
        "force": record.plate_force_x,
        "iterations": record.iterations,
        "certified": float(record.certified),
    }


def row(number: str, value: float, group: Group, as_it_is: dict[str, dict[str, float]]) -> dict[str, str | float]:
    """Return what a number in place of the package's does to each scene."""
    cells: dict[str, str | float] = {"number": number, "usual": f"{usual(number):g}", "here": f"{value:g}"}
    cells["code"] = sources()
    for scene, base in as_it_is.items():
        found = run(scene, changed(number, value), group)
        for what in ("energy", "force"):
            cells[f"{scene}: {what}"] = found[what] / base[what] - 1 if found else "failed"
        cells[f"{scene}: iterations"] = found["iterations"] / base["iterations"] if found else "failed"
        cells[f"{scene}: certified"] = "yes" if found and found["certified"] else "no"
    return cells


def table(rows: Iterable[Mapping[str, str | float]]) -> str:
    """Return the rows as Markdown."""
    return tables.markdown(COLUMNS, [[_shown(head, row.get(head, "")) for head in COLUMNS] for row in rows])


def _shown(head: str, value: str | float) -> str:
    """Return what stands in a column, with two digits where it was measured."""
    is_measured = head.endswith(_MEASURED) and value not in ("", "failed")
    return f"{float(value):.2g}" if is_measured else str(value)


def keep(new: Mapping[str, str | float], path: Path = TABLE) -> None:
    """Write a row in place of an older one of the same number and value."""
    key = new["number"], new["here"]
    rows = [row for row in tables.read(path) if (row["number"], row["here"]) != key]
    tables.write(path, COLUMNS, [*rows, new])


@described(__doc__)
@click.option("--only", default="", help="Numbers whose name has this text.")
@click.option("--scene", "scenes", multiple=True, type=click.Choice(list(SCENES)), help="These scenes only.")
def command(only: str, scenes: tuple[str, ...]) -> None:
    """Run all changes in all scenes, but for those that are known."""
    is_kept = not only and not scenes
    bases: list[dict[str, dict[str, float]]] = []
    for group in GROUPS:
        known = {(old["number"], old["here"]) for old in tables.read(TABLE) if is_kept and old["code"] == sources()}
        wanted = [(number, value) for number, values in group.changes.items() if only in number for value in values]
        names = [scene for scene in group.scenes if not scenes or scene in scenes] if wanted else []
        bases.append({scene: run(scene, group=group) for scene in names})
        for number, value in wanted:
            if (number, f"{value:g}") in known:
                continue
            new = row(number, value, group, bases[-1])
            click.echo(" ".join(_shown(*cell) for cell in new.items()), err=True)
            if is_kept:
                keep(new)
    if not is_kept:
        return
    heads = "; ".join(f"{scene} {found['energy']:.6e}" for scene, found in bases[0].items())
    order = [(number, f"{value:g}") for group in GROUPS for number in group.changes for value in group.changes[number]]
    found = {(row["number"], row["here"]): row for row in tables.read(TABLE)}
    REPORT.write_text(
        f"# What results depend on\n\n{date.today()}, {os.cpu_count()} cores, sources {sources()}. "
        "`python -m tools.studies constants` makes this: 3x3 tissues, each number of the solver changed by itself, the "
        f"last {len(AMONG_MANY)} on 6x6 tissues.\nEnergies and plate forces are relative changes, iterations a ratio. "
        f"Energies as it is: {heads}.\n\n{table(found[key] for key in order)}\n"
    )
