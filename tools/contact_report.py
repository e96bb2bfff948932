"""Tables and figures of the contact study: errors, the rates at which they fall, and what they cost."""

from __future__ import annotations

from collections.abc import Iterable
from math import log
from pathlib import Path
from statistics import median
from typing import Any

Row = dict[str, Any]

#: What is compared in each problem; a pressure that is 0 has no relative error, nor has a gap that is closed.
COMPARED = {
    "press-fit": ("bore", "interface", "pressure"),
    "tight-fit": ("bore", "interface", "pressure"),
    "pulled": ("gap",),
    "below": ("bore", "gap"),
    "touch": ("bore", "interface"),
    "above": ("bore", "interface", "pressure"),
}
#: Errors below this share are those of the solver's tolerance and of the reference; rates are not read from them.
FLOOR = 1e-8
#: Errors that a row gets, where the problem has them.
ERRORS = ("length", "contact pressure")
COLOURS = {"mortar": "C0", "penalty": "C1", "penalty x10": "C2"}
STYLES = {1: ":", 2: "--", 3: "-"}


def with_errors(row: Row, exact: dict[str, float]) -> Row:
    """Return a row with the relative errors of a run: the largest of its lengths, and that of its pressure."""
    if row["outcome"] != "converged":
        return row
    compared = COMPARED[row["problem"]]
    found = {name: abs(float(row[name]) / exact[name] - 1) for name in compared}
    lengths = max(error for name, error in found.items() if name != "pressure")
    return {**row, "length": lengths} | ({"contact pressure": found["pressure"]} if "pressure" in found else {})


def rates(rows: list[Row]) -> list[Row]:
    """Return, for each problem, order and method, errors by size and the rate between the last two sizes."""
    lines = []
    for key, mine in _grouped(rows, ("problem", "order", "method")).items():
        mine = sorted(mine, key=lambda row: -float(row["size"]))
        for what in ERRORS:
            found = [(float(row["size"]), row[what]) for row in mine if what in row]
            if found:
                line: Row = dict(zip(("problem", "order", "method"), key, strict=True)) | {"error of": what}
                line |= {f"h = {size:g}": f"{error:.1e}" for size, error in found}
                line["rate"] = _rate(found)
                lines.append(line)
    return lines


def _rate(found: list[tuple[float, float]]) -> str:
    usable = [(size, error) for size, error in found if error > FLOOR]
    if len(usable) < 2:
        return ""
    (coarse, before), (fine, after) = usable[-2:]
    return f"{log(before / after) / log(coarse / fine):.1f}"


def _grouped(rows: Iterable[Row], names: tuple[str, ...]) -> dict[tuple[str, ...], list[Row]]:
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(str(row[name]) for name in names), []).append(row)
    return groups


def report(rows: list[Row], text: Path, figures: Path | None, exact: dict[str, dict[str, float]]) -> None:
    """Write the tables, and the figures if there is a folder for them."""
    rows = [with_errors(row, exact[row["problem"]]) for row in rows]
    shown = ("problem", "method", "order", "size", "outcome", "unknowns", "iterations", "factorisations", "seconds")
    runs = [
        {name: row[name] for name in shown} | {name: f"{row[name]:.1e}" for name in ERRORS if name in row}
        for row in rows
    ]
    text.write_text("\n".join((markdown(rates(rows), "Relative errors and rates"), markdown(runs, "Runs"))))
    if figures is not None and pressed_throughout(rows):
        pressed = pressed_throughout(rows)
        error_over_seconds(pressed, figures / "contact-error-time.png")
        error_over_size(pressed, figures / "contact-rates.png")


def markdown(rows: list[Row], title: str) -> str:
    """Return rows as a Markdown table; rows may lack entries."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    lines = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    lines += ["| " + " | ".join(str(row.get(name, "")) for name in names) + " |" for row in rows]
    return "\n".join((f"## {title}", "", *lines, ""))


def pressed_throughout(rows: list[Row]) -> list[Row]:
    """Return the rows of problems in which rings press and that were solved in every run, so that sizes compare."""
    problems = {row["problem"] for row in rows if "contact pressure" in row}
    pressed = [row for row in rows if row["problem"] in problems]
    unsolved = {row["problem"] for row in pressed if "contact pressure" not in row}
    runs = {problem: sum(row["problem"] == problem for row in pressed) for problem in problems}
    return [row for row in pressed if row["problem"] not in unsolved and runs[row["problem"]] == max(runs.values())]


def typical(rows: list[Row], what: str, abscissa: str) -> dict[tuple[str, int], list[tuple[float, float]]]:
    """Return, for each method and order, the median over problems at each size of an abscissa and of an error."""
    lines: dict[tuple[str, int], list[tuple[float, float]]] = {}
    for (method, order, _), mine in _grouped(rows, ("method", "order", "size")).items():
        place = median(float(row[abscissa]) for row in mine)
        lines.setdefault((method, int(order)), []).append((place, median(row[what] for row in mine)))
    return lines


def error_over_seconds(rows: list[Row], path: Path) -> None:
    """Draw the error over processor seconds, one line a method and order."""
    _draw(rows, path, "seconds", "processor seconds", guides=())


def error_over_size(rows: list[Row], path: Path) -> None:
    """Draw the error over the size of elements, with slopes to compare with."""
    _draw(rows, path, "size", "size of elements", guides=(1, 2, 3, 4))


def _draw(rows: list[Row], path: Path, abscissa: str, label: str, *, guides: tuple[int, ...]) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    problems = ", ".join(dict.fromkeys(row["problem"] for row in rows))
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained", sharex=True)
    for axis, what in zip(axes, ERRORS, strict=True):
        for (method, order), points in sorted(typical(rows, what, abscissa).items()):
            x, y = zip(*sorted(points), strict=True)
            axis.loglog(x, y, STYLES[order], marker="o", ms=4, color=COLOURS[method], label=f"{method}, order {order}")
        low, high = axis.get_ylim()
        for slope in guides:
            x = min(float(row["size"]) for row in rows), max(float(row["size"]) for row in rows)
            axis.loglog(x, [0.7 * high * (at / x[1]) ** slope for at in x], color="0.8", lw=1, zorder=0)
            axis.text(x[0], 0.7 * high * (x[0] / x[1]) ** slope, f"{slope} ", ha="right", va="center", color="0.6")
        axis.set_ylim(low, high)
        axis.set(xlabel=label, ylabel="relative error", title=f"{what}: {problems}")
        axis.grid(alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right center", fontsize=8, handlelength=3)
    figure.savefig(path, dpi=150)
    plt.close(figure)
