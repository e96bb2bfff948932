"""Where the seconds of runs went, from their summaries: as a picture of one, a bar a phase, or as a table of several.

    ngcell solve shear-empty-3d --out out/shear-empty-3d
    python tools/phases.py out/shear-empty-3d                docs/phases-shear-empty-3d.png
    python tools/phases.py --cost                            tools/results/cost.md

The table is of the sheared tissue in one level, each scene solved several times, one after the other; of these the
run that took the least is told. Processor seconds, those of all threads together; the time on the clock stands in the
picture's title.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path
from typing import Any

import click
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
RESULTS = Path(__file__).resolve().parent / "results"
#: Below this share of all seconds phases are one bar.
_SMALL = 0.01


def bars(seconds: dict[str, Any]) -> list[tuple[str, float]]:
    """Return names and processor seconds of all phases, the longest first; those that are short together at the end."""
    phases, total = dict(seconds["processor_by_phase"]), seconds["processor"]
    phases["other"] = max(0.0, total - sum(phases.values()))
    long = {name: value for name, value in phases.items() if value >= _SMALL * total and name != "other"}
    rest = total - sum(long.values())
    return [*sorted(long.items(), key=lambda item: -item[1]), ("all others", rest)]


def draw(summary: dict[str, Any], file: Path) -> None:
    """Draw the bars of a run."""
    seconds, found = summary["seconds"], bars(summary["seconds"])
    figure = Figure(figsize=(8, 0.5 * len(found) + 1.3), layout="constrained")
    axes = figure.subplots()
    names, values = zip(*reversed(found), strict=True)
    drawn = axes.barh(names, values, color="C0")
    axes.bar_label(drawn, [f"{value:.0f} s, {value / seconds['processor']:.0%}" for value in values], padding=4)
    axes.set(xlabel="processor seconds", xlim=(0, 1.2 * max(values)))
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(
        f"{summary['title']}\n{summary['unknowns']:,} unknowns, {summary['iterations']} iterations, "
        f"{summary['factorisations']} factorisations,\n"
        f"{seconds['on_the_clock'] / 60:.1f} min on the clock; {summary['outcome']}",
        fontsize=10,
    )
    figure.savefig(file, dpi=130)


COST = {
    "3×3 to 1.0, in one step": ("shear-empty-3x3", "single-step"),
    "3×3 to 1.0, tied then released": ("shear-empty-3x3", "sddp"),
    "5×7 to 1.6, in one step": ("shear-empty", "single-step"),
    "5×7 to 1.6, tied then released": ("shear-empty", "sddp"),
}
#: Phases that the interpreter and the pictures take, whatever is solved.
_ASIDE = ("imports", "pictures")


def cheapest(case: str, strategy: str, times: int) -> dict[str, Any]:
    """Return the summary of the run that took the least processor time."""
    runs = []
    for _ in range(times):
        with tempfile.TemporaryDirectory() as folder:
            settings = ["--set", "load.levels=1", "--set", f'strategy.kind="{strategy}"']
            command = [sys.executable, "-m", "ngcell", "solve", case, *settings, "--quiet", "--out", folder]
            subprocess.run(command, check=True, capture_output=True)
            runs.append(json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8")))
    return min(runs, key=lambda summary: summary["seconds"]["processor"])


def cost_table(times: int) -> str:
    """Return the Markdown table of the cost of the sheared tissue."""
    summaries = {name: cheapest(*scene, times) for name, scene in COST.items()}
    phases = [name for name in next(iter(summaries.values()))["seconds"]["processor_by_phase"] if name not in _ASIDE]
    lines = [
        "# What the sheared tissue costs",
        "",
        f"{date.today()}, 2 cores. `python tools/phases.py --cost` makes this: processor seconds of the cheapest of "
        f"{times} runs.",
        "",
        "| scene | unknowns | iterations | factorisations | " + " | ".join([*phases, "these", *_ASIDE, "whole"]) + " |",
        "|---" * (len(phases) + 8) + "|",
    ]
    for name, summary in summaries.items():
        seconds = summary["seconds"]["processor_by_phase"]
        numbers = [seconds[phase] for phase in phases]
        numbers += [sum(numbers), *(seconds[phase] for phase in _ASIDE), summary["seconds"]["processor"]]
        counts = (str(summary[key]) for key in ("unknowns", "iterations", "factorisations"))
        lines.append(f"| {' | '.join([name, *counts, *(f'{number:.2f}' for number in numbers)])} |")
    return "\n".join(lines) + "\n"


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True), required=False)
@click.option("--cost", is_flag=True, help="Solve the sheared tissue and tabulate its cost.")
@click.option("--times", default=5, show_default=True, help="Runs of each scene.")
def main(folder: Path | None, cost: bool, times: int) -> None:
    """Draw where the seconds of the run in FOLDER went, or tabulate the cost of the sheared tissue."""
    if cost:
        (RESULTS / "cost.md").write_text(cost_table(times), encoding="utf-8")
    if folder is None:
        return
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    file = ROOT / "docs" / f"phases-{folder.resolve().name}.png"
    draw(summary, file)
    for name, value in bars(summary["seconds"]):
        click.echo(f"{name:24}{value:10.1f} s")
    click.echo(f"{'on the clock':24}{summary['seconds']['on_the_clock']:10.1f} s")


if __name__ == "__main__":
    main()
