"""Blocks, rings and seven cells by other programs that are installed, beside this package: errors and seconds.

    python -m tools.references peers                              all problems by all programs that are here
    python -m tools.references peers --problem cells --count 2    one of them, by elements two of which are across

Rows of `tools/results/peers.csv` that are not run again stay. What is not installed is named, and left out; a run that
fails, or is stopped after two minutes, has a row that says so. The reference of the cells takes five minutes; it is
computed where the table has none, or with --reference.
"""

from __future__ import annotations

from collections.abc import Iterable

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.references.peers.rows import COLUMNS, PROBLEMS, REFERENCE, Row, judged, merged, missing, references, runs

#: Elements across the first body.
COUNTS = {"blocks": (2, 4, 8), "rings": (2, 4, 8), "cells": (1, 2, 4)}
TABLE = RESULTS / "peers.csv"

#: What the table needs to be read.
ABOUT = """\
`python -m tools.references peers`. Sizes of elements are the same in all programs. CalculiX has one layer of hexahedra,
quadratic (C3D20R) or linear (C3D8), and a penalty 30 times as stiff as a layer of elements, from surface to surface;
GetFEM quadrilaterals and an augmented Lagrangian by ray tracing, whose parameter is kappa + 4/3 mu; this package
triangles, penalties 100 times as stiff, and the mortar method. Seconds are those on the clock of one run on one thread,
on a machine that was busy with other work, without the start of this package, with that of the others.

Errors of blocks and rings are those of the force, against what is exact for the volumetric energy of each program.
"""


@described(__doc__)
@click.option("--problem", "names", type=click.Choice(PROBLEMS), multiple=True, default=PROBLEMS, help="What to solve.")
@click.option("--count", "counts", type=int, multiple=True, help="Elements across the first body.")
@click.option("--reference", "again", is_flag=True, help="Compute the reference of the cells again.")
def command(names: tuple[str, ...], counts: tuple[int, ...], again: bool) -> None:
    """Solve problems by all programs and write the tables."""
    for line in missing():
        click.echo(f"{line}; its lines are left out", err=True)
    if "cells" in names and (again or REFERENCE not in {row["program"] for row in tables.read(TABLE)}):
        _keep(references())
    for name in names:
        _keep(runs(name, counts or COUNTS[name]))


def _keep(rows: Iterable[Row]) -> None:
    """Write each row into the tables as soon as it is there."""
    for row in rows:
        table = judged(merged(tables.read(TABLE), [row]))
        tables.write(TABLE, COLUMNS, table)
        lines = [[_short(found[column]) for column in COLUMNS] for found in table]
        text = f"# Blocks, rings and seven cells by other programs\n\n{ABOUT}\n{tables.markdown(COLUMNS, lines)}\n"
        TABLE.with_suffix(".md").write_text(text, encoding="utf-8")
        click.echo(", ".join(row[column] for column in COLUMNS), err=True)


def _short(entry: str) -> str:
    """Return an entry with six digits, if it is a number that has more."""
    return f"{float(entry):.6g}" if len(entry) > 8 and entry.replace(".", "").replace("e-", "").isdigit() else entry
