"""Run the points that have no row yet, and tell what came of all of them.

    python -m tools.extreme map --quick               some forty points, in about four minutes
    python -m tools.extreme map [--timeout 120]       all of them, and the perturbed ones

Rows are kept in `tools/results/extreme.csv`; a point that has its row there, made by the same sources of the package,
is not repeated, so that a run that was stopped goes on. At the end `extreme.md` beside it tells what came of every
point, and `docs/extreme.png` shows it; `--quick` writes to `extreme-quick.csv` and `.md`, and no figure.
"""

from __future__ import annotations

import shutil

import click

from tools.commands import described
from tools.extreme.outcomes import FOLDERS, compare, known, solve, write
from tools.extreme.points import points
from tools.extreme.report import report
from tools.places import DOCS, RESULTS
from tools.runs import sources


@described(__doc__)
@click.option("--quick", is_flag=True, help="Some forty points, and no figure.")
@click.option("--timeout", default=120.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Points whose label has this text; rows of others stay.")
@click.option("--report-only", is_flag=True, help="Write table and figure of the rows that are there.")
def command(quick: bool, timeout: float, only: str, report_only: bool) -> None:
    """Run and report."""
    file = RESULTS / ("extreme-quick.csv" if quick else "extreme.csv")
    chosen = [point for point in points() if point.is_quick or not quick]
    code = sources()
    rows = known(file, None if report_only or only else code)  # those of other sources stay where few are asked for
    for point in sorted(chosen, key=lambda point: (not point.is_quick, bool(point.perturbed_from))):
        is_made = point.label in rows and rows[point.label].code == code
        if report_only or is_made or only not in point.label:
            continue
        rows[point.label] = row = solve(point, timeout, code)
        compare(point, rows)
        click.echo(f"{row.outcome:9}  {row.seconds:6.1f} s  {row.label}  {row.cause}", err=True)
        write(file, list(rows.values()))
    shutil.rmtree(FOLDERS, ignore_errors=True)
    found = [rows[point.label] for point in chosen if point.label in rows]
    asked = sum(not point.perturbed_from for point in chosen)
    report(found, asked, file.with_suffix(".md"), None if quick else DOCS / "extreme.png")
