"""Error against run time of each kind of contact: a press-fit, Hertz contact, tissues.

    python -m tools.studies contact-kinds [--scene NAME] [--show]      docs/contact-kinds.png

Tissues are run at accuracies, bodies at orders, one level each, with processor seconds on one thread. Errors are told
as the run estimates them, and as they are found against the last setting: by the mortar method, whose result knows no
stiffness, and by the penalty for the larger tissue. Runs of a scene at a setting alternate between kinds, and the
cheaper of two counts; `ngsolve` and references are run once.
Rows go to `tools/results/contact-kinds.csv`; those of the present sources are not repeated.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from time import process_time
from typing import Any

import click
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

import ngcell
from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import sources

TABLE, REPORT, FIGURE = (
    RESULTS / "contact-kinds.csv", RESULTS / "contact-kinds.md", DOCS / "contact-kinds.png",
)  # fmt: skip
KINDS = ("penalty", "mortar", "ngsolve")
SMALL, LARGE = "shear-empty-3x3", "shear-empty"
ONE, PRESSURE = "load.levels=1", 'lumen.kind="pressure"'
ROUGH, USUAL, FINEST = "accuracy=0.1", "accuracy=0.01", "accuracy=0.0001"
ORDERS = ("mesh.order=1", "mesh.order=2", "mesh.order=3", "mesh.order=4")
#: Case, what is set, and the settings; the last one is the reference, by one method alone.
SCENES: dict[str, tuple[str, tuple[str, ...], tuple[str, ...]]] = {
    "press-fit": ("press-fit", (), ORDERS),
    "Hertz": ("hertz-cylinders", ("levels=1",), ORDERS),
    "3x3 to 0.4": (SMALL, ("load.displacement=[0.4, 0.0]", ONE), (ROUGH, USUAL, FINEST)),
    "3x3 to 1.0": (SMALL, (ONE,), (ROUGH, USUAL, FINEST)),
    "3x3 to 1.0 under 0.01": (SMALL, (ONE, PRESSURE, "lumen.pressure=0.01"), (ROUGH, USUAL, FINEST)),
    "5x7 to 1.6": (LARGE, (ONE,), (ROUGH, USUAL)),
    "5x7 to 1.6 under 0.005": (LARGE, (ONE, PRESSURE, "lumen.pressure=0.005"), (ROUGH, USUAL)),
}
#: Numbers that are told, and the columns of their errors; what a scene has none of is left out.
NUMBERS = {
    "energy": "energy_error", "plate_force_x": "plate_force_error", "contact_force": "contact_force_error",
    "mean_gap": "mean_gap_error",
}  # fmt: skip
COLUMNS = (
    "scene", "setting", "contact", *(part for pair in NUMBERS.items() for part in pair), "certified", "iterations",
    "factorisations", "seconds", "code",
)  # fmt: skip
#: Forces and gaps below this are none, in scenes of size and modulus one.
_NOTHING = 1e-6
Row = dict[str, Any]


def measured(scene: str, setting: str, kind: str) -> Row:
    """Solve a scene by a kind of contact, and return its row; one without numbers where a step fails."""
    name, sets, _ = SCENES[scene]
    row: Row = {"scene": scene, "setting": setting, "contact": kind, "code": sources(), "certified": False}
    started = process_time()
    try:
        steps: Sequence[ngcell.Step] = ngcell.simulate(ngcell.read_case(name, [*sets, setting, f"contact.kind={kind}"]))
    except ngcell.NotConverged:
        return row | {"seconds": round(process_time() - started, 2)}
    row["seconds"], record = round(process_time() - started, 2), steps[-1].record
    row |= {column: getattr(record, column) for column in COLUMNS if hasattr(record, column) and column != "seconds"}
    for effort in ("iterations", "factorisations"):
        row[effort] = sum(getattr(step.record, effort) for step in steps)
    return row | {"certified": all(step.record.certified for step in steps)}


def missing(known: Iterable[Row], scenes: Iterable[str]) -> list[tuple[str, str, str]]:
    """Return the scenes, settings and kinds that the table has no row for from the present sources."""
    done = {(row["scene"], row["setting"], row["contact"]) for row in known if row["code"] == sources()}
    wanted = []
    for scene in scenes:
        *settings, _ = SCENES[scene][2]
        wanted += [(scene, setting, kind) for setting in settings for kind in KINDS] + [reference(scene)]
    return [run for run in wanted if run not in done]


def reference(scene: str) -> tuple[str, str, str]:
    """Return scene, setting and kind of the run that errors are told against."""
    return scene, SCENES[scene][2][-1], "penalty" if SCENES[scene][0] == LARGE else "mortar"


def cheaper(one: Row, two: Row) -> Row:
    """Return the row that took less."""
    return one if one["seconds"] <= two["seconds"] else two


def found(rows: Sequence[Row], row: Row, number: str) -> float | None:
    """Return the relative error of a number against the reference; None where one of them has none."""
    key = reference(row["scene"])
    exact = next((other[number] for other in rows if (other["scene"], other["setting"], other["contact"]) == key), "")
    if not exact or not row[number] or abs(float(exact)) < _NOTHING:
        return None
    return abs(float(row[number]) / float(exact) - 1)


def told(row: Row, number: str) -> float | None:
    """Return the relative error of a number that its run estimates."""
    if not row[number] or abs(float(row[number])) < _NOTHING:
        return None
    return float(row[NUMBERS[number]]) / abs(float(row[number]))


def report(rows: Sequence[Row]) -> str:
    """Return the table of errors and times."""
    names = (number.replace("_", " ") for number in NUMBERS)
    head = ("scene", "setting", "contact", *names, "certified", "iterations", "factorisations", "s", "code")
    lines = []
    for row in rows:
        pairs = []
        for number in NUMBERS:
            errors = told(row, number), found(rows, row, number)
            shown = ["" if error is None else f"{100 * error:.2g}" for error in errors]
            pairs.append(" / ".join(shown) if any(shown) else "")
        effort = (row["certified"], row["iterations"], row["factorisations"], row["seconds"], row["code"])
        lines.append((row["scene"], row["setting"], row["contact"], *pairs, *effort))
    first, _, rest = (__doc__ or "").partition("\n\n")
    said = rest.partition("\n\n")[2].strip()
    words = f"{first} Errors in percent, estimated / found. {said}"
    return f"# Kinds of contact\n\n{words}\n\n{tables.markdown(head, lines)}\n"


def draw(rows: Sequence[Row]) -> None:
    """Draw the error found of the energy over the seconds, a panel a scene; hollow where a run is not certified."""
    scenes = [scene for scene in SCENES if any(row["scene"] == scene for row in rows)]
    figure = Figure(figsize=(12, 5.6), layout="constrained")
    panels = figure.subplots(2, (len(scenes) + 1) // 2, squeeze=False).ravel()
    for axes in panels[len(scenes) :]:
        axes.set_visible(False)
    for axes, scene in zip(panels, scenes, strict=False):
        for kind, colour in zip(KINDS, ("C0", "C1", "C2"), strict=True):
            mine = [row for row in rows if (row["scene"], row["contact"]) == (scene, kind)]
            points = [(float(row["seconds"]), found(rows, row, "energy"), row["certified"]) for row in mine]
            shown = [(x, 100 * y, good) for x, y, good in points if y]
            axes.plot([x for x, *_ in shown], [y for _, y, _ in shown], color=colour, label=kind)
            for x, y, good in shown:
                face = colour if str(good) == "True" else "white"
                axes.plot(x, y, "o", color=colour, markerfacecolor=face)
        axes.set(xscale="log", yscale="log", title=scene, xlabel="processor seconds", ylabel="error of the energy [%]")
        axes.margins(0.15)
        falls_far = SCENES[scene][2] is ORDERS
        for axis, parts in ((axes.xaxis, (1, 2, 5)), (axes.yaxis, (1,) if falls_far else (1, 2, 5))):
            axis.set_major_locator(LogLocator(subs=parts))
            axis.set_major_formatter(FormatStrFormatter("%g"))
            axis.set_minor_formatter(NullFormatter())
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower right", frameon=False)
    figure.savefig(FIGURE, dpi=110)


@described(__doc__)
@click.option("--scene", "only", default="", help="Only scenes whose names hold this.")
@click.option("--show", is_flag=True, help="Write table and figure from the rows that are there, and run nothing.")
def command(only: str, show: bool) -> None:
    """Run what is missing, write the tables, and draw."""
    runs = [] if show else missing(tables.read(TABLE), [scene for scene in SCENES if only in scene])
    for again in (False, True):
        for run in runs:
            if again and (run[2] == "ngsolve" or run == reference(run[0])):
                continue
            new = measured(*run)
            rows = tables.read(TABLE)
            old = [row for row in rows if (row["scene"], row["setting"], row["contact"]) == run]
            kept = cheaper(new, old[0] | {"seconds": float(old[0]["seconds"])}) if again and old else new
            merged: list[Row] = [*(row for row in rows if row not in old), kept]
            merged.sort(key=_place)
            tables.write(TABLE, COLUMNS, merged)
            click.echo(", ".join(f"{key} {value}" for key, value in new.items()), err=True)
    rows = tables.read(TABLE)
    REPORT.write_text(report(rows), encoding="utf-8")
    draw(rows)
    click.echo(str(FIGURE))


def _place(row: Row) -> tuple[int, int, int]:
    scene = row["scene"]
    return list(SCENES).index(scene), SCENES[scene][2].index(row["setting"]), KINDS.index(row["contact"])
