"""What the sheared tissue costs in one level, phase by phase.

    python -m tools.studies cost [--times 5]

Processor seconds of the cheapest of several runs. Scenes are solved in turns, so that a slow minute of the machine is
not that of one scene. The table goes to `tools/results/cost.md`.
"""

from __future__ import annotations

import tempfile
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import alternating, ended, solve_words, summary_in

SCENES = {
    "3×3 to 1.0, in one step": ("shear-empty-3x3", "single-step"),
    "3×3 to 1.0, tied then released": ("shear-empty-3x3", "sddp"),
    "5×7 to 1.6, in one step": ("shear-empty", "single-step"),
    "5×7 to 1.6, tied then released": ("shear-empty", "sddp"),
}
#: Phases that the interpreter and the pictures take, whatever is solved.
_ASIDE = ("imports", "pictures")


def summary_of(case: str, strategy: str) -> dict[str, Any]:
    """Solve a case in one level and return its summary."""
    with tempfile.TemporaryDirectory() as folder:
        words = solve_words(case, Path(folder), ("load.levels=1", f'strategy.kind="{strategy}"', "accuracy=inf"))
        run = ended(*words, "--quiet")
        if run.exit_code:
            raise click.ClickException(f"{case}, {strategy}: {run.last_words('no words')}")
        return summary_in(Path(folder))


def table(summaries: dict[str, dict[str, Any]]) -> str:
    """Return the Markdown table."""
    phases = [name for name in next(iter(summaries.values()))["seconds"]["processor_by_phase"] if name not in _ASIDE]
    columns = ("scene", "unknowns", "iterations", "factorisations", *phases, "these", *_ASIDE, "whole")
    return tables.markdown(columns, [_line(name, phases, summary) for name, summary in summaries.items()])


def _line(name: str, phases: list[str], summary: dict[str, Any]) -> list[str]:
    seconds = summary["seconds"]["processor_by_phase"]
    numbers = [seconds[phase] for phase in phases]
    numbers += [sum(numbers), *(seconds[phase] for phase in _ASIDE), summary["seconds"]["processor"]]
    counts = (str(summary[key]) for key in ("unknowns", "iterations", "factorisations"))
    return [name, *counts, *(f"{number:.2f}" for number in numbers)]


@described(__doc__)
@click.option("--times", default=5, show_default=True, help="Runs of each scene.")
@click.option("--only", default="", help="Scenes whose name has this text; the table is shown and not kept.")
def command(times: int, only: str) -> None:
    """Solve and tabulate."""
    scenes = {name: partial(summary_of, *scene) for name, scene in SCENES.items() if only in name}
    cheapest = {
        name: min(found, key=lambda summary: summary["seconds"]["processor"])
        for name, found in alternating(scenes, times).items()
    }
    if only:
        click.echo(table(cheapest))
        return
    head = (
        "# What the sheared tissue costs\n\n"
        f"{date.today()}, 2 cores. `python -m tools.studies cost` makes this: processor seconds of the cheapest of "
        f"{times} runs.\n\n"
    )
    (RESULTS / "cost.md").write_text(f"{head}{table(cheapest)}\n", encoding="utf-8")
