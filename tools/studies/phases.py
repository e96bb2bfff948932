"""Where the seconds of a run went, from its summary: a bar a phase.

    ngcell solve shear-empty-3d --out out/shear-empty-3d
    python -m tools.studies phases out/shear-empty-3d        docs/phases-shear-empty-3d.png

Seconds are those of the processor, of all threads together; the time on the clock stands in the picture's title.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from matplotlib.figure import Figure

from tools.commands import described
from tools.places import DOCS
from tools.runs import summary_in

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


@described(__doc__)
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
@click.option("--out", type=click.Path(path_type=Path), help="The picture; by default docs/phases-NAME.png.")
def command(folder: Path, out: Path | None) -> None:
    """Draw and tell where the seconds of the run in FOLDER went."""
    summary = summary_in(folder)
    if "seconds" not in summary:
        raise click.ClickException(f"{folder}: it holds no run that has ended; run `ngcell solve CASE --out {folder}`")
    draw(summary, out or DOCS / f"phases-{folder.resolve().name}.png")
    for name, value in bars(summary["seconds"]):
        click.echo(f"{name:24}{value:10.1f} s")
    click.echo(f"{'on the clock':24}{summary['seconds']['on_the_clock']:10.1f} s")
