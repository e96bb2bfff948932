"""What fourteen tissues of 35 to 49 cells take altogether: what a change of a solver is judged by.

    python -m tools.studies averaged [--accuracy NUMBER] [--minutes NUMBER] [--both-passes]

Where a tissue comes apart, last digits decide which corner slips first, and one scene may take half as long again after
a change that means nothing. The sum over scenes that differ a little in shear, walls, pressure and number of cells
hardly moves by that. Each run is a process of its own, in one level, on one thread; columns are those of `growing`.
The table goes to `tools/results/averaged.md`, at another accuracy to `averaged-0.03.md` and so on; with contact of both
passes at corners to `averaged-both-passes.md`.
"""

from __future__ import annotations

from collections.abc import Iterable

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.studies.growing import COLUMNS, Row, measured

#: The accuracy of the table without a suffix.
_USUAL = 0.1
SCENES: dict[str, tuple[str, tuple[str, ...]]] = {
    **{
        f"5x7 to {displacement:g}": ("shear-empty", (f"load.displacement=[{displacement}, 0.0]",))
        for displacement in (1.2, 1.4, 1.55, 1.6, 1.65, 1.8)
    },
    **{f"5x7, walls of {wall:g}": ("shear-empty", (f"tissue.wall={wall}",)) for wall in (0.09, 0.11)},
    "5x7 to 1.4 under 0.005": ("shear-pressurised", ("load.displacement=[1.4, 0.0]",)),
    **{
        f"5x7 under {pressure:g}": ("shear-pressurised", (f"lumen.pressure={pressure}",))
        for pressure in (0.005, 0.0075, 0.01)
    },
    "6x6": ("shear-empty", ("tissue.rows=6", "tissue.cols=6")),
    "7x7 to 1.1": ("shear-empty", ("tissue.rows=7", "tissue.cols=7", "load.displacement=[1.1, 0.0]")),
}
_SUMS = ("iterations", "factorisations", "refused", "seconds", "factorisation", "assembly")


def total(rows: Iterable[Row]) -> Row:
    """Return the sums over runs, and how many of them are certified."""
    rows = list(rows)
    certified = sum(row["outcome"] == "converged and certified" for row in rows)
    sums = {column: sum(int(row[column] or 0) for row in rows) for column in _SUMS}
    return {"tissue": "all", "outcome": f"{certified} of {len(rows)} certified"} | sums


@described(__doc__)
@click.option("--accuracy", default=_USUAL, show_default=True, type=click.FloatRange(0, min_open=True))
@click.option("--minutes", default=10.0, show_default=True, help="Most minutes of a run.")
@click.option("--both-passes", is_flag=True, help="Contact with both passes at corners.")
def command(accuracy: float, minutes: float, both_passes: bool) -> None:
    """Run all, and report."""
    rows, changes = [], ("contact.single_pass_corners=false",) if both_passes else ()
    for name, (case, sets) in SCENES.items():
        rows.append({"tissue": name} | measured(case, (*sets, *changes), accuracy, minutes))
        click.echo(" ".join(f"{key}={value}" for key, value in rows[-1].items()), err=True)
    words = (__doc__ or "").partition("\n\n")
    said = words[2].partition("\n\n")[2].strip()
    lines = [[row.get(column, "") for column in COLUMNS] for row in (*rows, total(rows))]
    text = f"# Tissues on average\n\n{words[0]} {said}\n\n{tables.markdown(COLUMNS, lines)}\n"
    name = "averaged" + "-both-passes" * both_passes + f"-{accuracy:g}" * (accuracy != _USUAL)
    (RESULTS / f"{name}.md").write_text(text, encoding="utf-8")
