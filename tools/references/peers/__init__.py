"""Blocks, rings and seven cells by other programs, if installed, beside this package: errors, seconds.

    python -m tools.references peers                              all problems by all programs that are here
    python -m tools.references peers --problem cells --count 2    one of them, by elements two of which are across

Rows of `tools/results/peers.csv` that are not run again stay. What is not installed is named, and left out; a run that
fails, or is stopped after two minutes, has a row that says so. The reference of the cells takes three minutes; it
is computed where the table has none, or with --reference.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.references.peers.rows import (
    COLUMNS,
    KEY,
    PROBLEMS,
    REFERENCE,
    Row,
    judged,
    merged,
    missing,
    references,
    runs,
)

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

Seven cells: all programs have the volumetric energy kappa/2 (J - 1)^2, this package by a law of a script, so that laws
do not differ; kappa is only ten times the shear modulus, so that elements do not lock by it. Neighbours are one pair of
walls each, twelve in all, and their grids match at rest. GetFEM has its multipliers on the walls of the centre cell and
on `wall2` of the others, CalculiX its points on the walls opposite. Corners are cut off: with sharp ones forces of this
package differed between fine meshes by 2 %, at a single cell by 8 %, presumably by the side on which corners pass each
other. Under a stretch of 3 % beside a compression of 8 % openings differed by up to twice; so cells are stretched as
much as they are compressed. The reference is not exact: it is the mortar method at order 4 on a mesh that is graded
once towards corners of lumens and ends of what is held. The penalty on a mesh that is graded twice, where the mortar
method had not ended after six minutes, agrees with it to 0.1 % in the force and 0.6 % in the opening, GetFEM at order 2
with four elements across to 0.1 % and 4 %. But on meshes that are not graded this package, with four elements across,
comes to forces 1.7 to 1.8 % above it by either method, whether at order 2 or 3: the force is known to about 2 %, the
opening to 1 % by this package and 4 % by all, and smaller errors in this table mean nothing.
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
        write(table)
        found = next(line for line in table if all(line[name] == row[name] for name in KEY))
        click.echo(", ".join(found.values()), err=True)


def write(table: Sequence[Row]) -> None:
    """Write both tables."""
    tables.write(TABLE, COLUMNS, table)
    lines = [[_short(row[column]) for column in COLUMNS] for row in table]
    text = f"# Blocks, rings and seven cells by other programs\n\n{ABOUT}\n{tables.markdown(COLUMNS, lines)}\n"
    TABLE.with_suffix(".md").write_text(text, encoding="utf-8")


def _short(entry: str) -> str:
    """Return an entry with six digits, if it is a number that has more."""
    return f"{float(entry):.6g}" if len(entry) > 8 and entry.replace(".", "").replace("e-", "").isdigit() else entry
