"""What a study says: errors against references, rates, costs, strategies, figures, and sentences."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable
from datetime import date
from math import log
from pathlib import Path
from statistics import median
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from tools import tables

Row = dict[str, Any]

WHAT = ("gap", "pressure", "force", "energy")
#: Errors below this share are those of the solver's tolerance and of the reference; rates are not read from them.
FLOOR = 1e-8
TARGETS = (0.1, 0.01, 0.001)
COLOURS = {"mortar": "C0", "penalty x0.1": "C4", "penalty": "C1", "penalty x10": "C2", "naive": "C3", "calculix": "C5"}
#: Who else solves rings, and which.
PEERS, ASKED_OF_PEERS = ("naive", "calculix"), ("press-fit", "above")
STYLES = {1: ":", 2: "--", 3: "-", 4: "-."}


def report(rows: list[Row], asked: int, text: Path, figures: Path | None) -> None:
    """Write the tables, and the figures if there is a folder for them."""
    if not rows:
        return
    solved = [row for row in rows if row["outcome"] == "converged"]
    exact = [with_errors(row) for row in solved if row["kind"] != "tissue"]
    tissues = [row for row in solved if row["kind"] == "tissue"]
    single = [row for row in tissues if "shear" not in row["problem"]]
    against_finest, references = against_own_finest(single)
    parts = [head(rows, asked), sentences(exact, against_finest)]
    parts += [markdown(rates(exact), "Exact problems: relative errors and rates")]
    if any(row["kind"] in PEERS for row in rows):
        parts += [markdown(peers_table(rows), "Peers beside this package on the same mesh: largest relative error")]
    if references:
        parts += [markdown(references, "References of tissues: the finest setting of each method, cross-checked")]
    if against_finest:
        shown_rows = [shown(row) for row in against_finest]
        parts += [markdown(shown_rows, "Tissues: errors against the mortar's finest setting")]
    strategies = strategy_table([row for row in rows if "shear" in row["problem"]])
    if strategies:
        parts += [markdown(strategies, "SDDP and single-step: both over shear, pressure and stiffness of inclusions")]
    failed = [{"run": row["run"], "outcome": row["outcome"]} for row in rows if row["outcome"] != "converged"]
    if failed:
        parts += [markdown(failed, "Runs that did not end")]
    parts += [markdown([costs(row) for row in solved], "What runs took")]
    text.write_text("\n".join(parts))
    if figures is not None:
        work_precision(exact, against_finest, figures / "study-work-precision.png")


def head(rows: list[Row], asked: int) -> str:
    """Say when, where and by what."""
    codes = ", ".join(sorted({f"{row['commit']} (sources {row['code']})".strip() for row in rows}))
    machine = f"{platform.machine()}, {os.cpu_count()} cores, {_processor()}"
    return (
        f"# Error against run time\n\n{date.today()}, {machine}; package at {codes}. Seconds are those of one\n"
        "processor, imports and measurements aside. `python -m tools.studies work-precision` makes this;\n"
        f"{len(rows)} of its {asked} runs are here.\n"
    )


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def with_errors(row: Row) -> Row:
    """Return a row of an exact problem with its errors as numbers."""
    return row | {name: float(row[f"error_{name}"]) for name in WHAT if row.get(f"error_{name}") not in ("", None)}


def against_own_finest(rows: list[Row]) -> tuple[list[Row], list[Row]]:
    """Return tissue rows with errors against the mortar's finest setting, and how far the penalty's is from it."""
    compared, references = [], []
    for (problem,), mine in grouped(rows, ("problem",)).items():
        finest = {
            method: min(same, key=lambda row: (float(row["size"]), -int(row["order"])))
            for (method,), same in grouped(mine, ("method",)).items()
        }
        if "mortar" not in finest or len(mine) < 3:
            continue
        reference = finest["mortar"]
        for row in mine:
            if row is not reference:
                compared.append(row_without_values(row) | _differences(row, reference))
        for method, row in finest.items():
            if row is not reference:
                line = {"problem": problem, "method": method, "order": row["order"], "h": row["size"]}
                line |= {what: f"{value:.1e}" for what, value in _differences(row, reference).items()}
                references.append(line | {"parted": f"{row['parted']} and {reference['parted']}"})
    return compared, references


def row_without_values(row: Row) -> Row:
    """Return a row without the quantities that errors take the place of."""
    return {name: value for name, value in row.items() if name not in WHAT}


def _differences(row: Row, reference: Row) -> dict[str, float]:
    return {what: abs(float(row[what]) / float(reference[what]) - 1) for what in WHAT if float(reference[what])}


def rates(rows: list[Row]) -> list[Row]:
    """Return, for each problem, order and method, errors by size and the rate between the last two sizes."""
    lines = []
    for key, mine in grouped(rows, ("problem", "order", "method")).items():
        mine = sorted(mine, key=lambda row: -float(row["size"]))
        for what in WHAT:
            found = [(float(row["size"]), row[what]) for row in mine if what in row and row[what] != ""]
            found = [(size, error) for size, error in found if isinstance(error, float)]
            if found:
                line: Row = dict(zip(("problem", "order", "method"), key, strict=True)) | {"error of": what}
                line |= {f"h = {size:g}": f"{error:.1e}" for size, error in found if size < 1}
                lines.append(line | {"rate": _rate(found)})
    return lines


def _rate(found: list[tuple[float, float]]) -> str:
    usable = [(size, error) for size, error in found if error > FLOOR]
    if len(usable) < 2:
        return ""
    (coarse, before), (fine, after) = usable[-2:]
    return f"{log(before / after) / log(coarse / fine):.1f}"


def groups_of(exact: list[Row], tissues: list[Row]) -> dict[str, list[Row]]:
    """Return the rows that a sentence and a panel each are about."""
    rings = [row for row in exact if row["kind"] in ("rings", "naive", "calculix") and "soft" not in row["problem"]]
    pressed = [row for row in rings if isinstance(row.get("pressure"), float)]
    return {"pressed rings": pressed, **{p: m for (p,), m in grouped(tissues, ("problem",)).items()}}


def worst(rows: list[Row]) -> float:
    """Return the largest error of any problem and quantity."""
    return max(float(row[what]) for row in rows for what in WHAT if isinstance(row.get(what), float))


def choices(rows: list[Row]) -> list[Row]:
    """Return median seconds and worst error of each method, order and size that solved all that it was asked."""
    problems = {row["problem"] for row in rows if row["kind"] in ("rings", "tissue")}
    lines = []
    for (kind, method, order, size), mine in grouped(rows, ("kind", "method", "order", "size")).items():
        asked = problems & set(ASKED_OF_PEERS) if kind in PEERS else problems
        if {row["problem"] for row in mine} >= asked:
            seconds = median(float(row["seconds"]) for row in mine)
            lines.append({"method": method, "order": int(order), "size": float(size), "seconds": seconds,
                          "error": worst(mine)})  # fmt: skip
    return lines


def upper_end(lines: list[Row]) -> list[Row]:
    """Return the choices that no other is both quicker and more exact than."""
    best, kept = float("inf"), []
    for line in sorted(lines, key=lambda line: (line["seconds"], line["error"])):
        if line["error"] < best:
            best = line["error"]
            kept.append(line)
    return kept


def sentences(exact: list[Row], tissues: list[Row]) -> str:
    """Say which setting gives which error at what cost."""
    said = ["## What follows\n"]
    for name, rows in groups_of(exact, tissues).items():
        lines = [line for line in choices(rows) if line["method"] not in PEERS]
        for target in TARGETS:
            enough = [line for line in lines if line["error"] <= target]
            if not enough:
                said.append(f"- {name}: no setting of this study has all errors below {target:.1%}.")
                continue
            best = min(enough, key=lambda line: line["seconds"])
            said.append(
                f"- {name}: errors below {target:.1%} take {best['seconds']:.2g} s, with {best['method']}, order "
                f"{best['order']}, h = {best['size']:g} (largest error {best['error']:.1e})."
            )
    return "\n".join([*said, ""])


def peers_table(rows: list[Row]) -> list[Row]:
    """Return a line a mesh and order: largest error and seconds of a peer, and of this package's methods there."""
    lines = []
    for peer in (row for row in rows if row["kind"] in PEERS):
        line = {"problem": peer["problem"], "order": peer["order"], "h": peer["size"], peer["method"]: _found(peer)}
        for row in rows:
            same = all(str(row[name]) == str(peer[name]) for name in ("problem", "order", "size"))
            if same and row["kind"] == "rings" and row["method"] in ("penalty", "mortar"):
                line[row["method"]] = _found(row)
        lines.append(line)
    return lines


def _found(row: Row) -> str:
    if row["outcome"] != "converged":
        return str(row["outcome"])
    return f"{worst([with_errors(row)]):.1e} in {float(row['seconds']):.2g} s"


def strategy_table(rows: list[Row]) -> list[Row]:
    """Return a line a scene: outcome, seconds, iterations and factorisations of both strategies, and their ratio."""
    lines = []
    for (problem,), mine in grouped(rows, ("problem",)).items():
        by = {row["strategy"]: row for row in mine}
        if len(by) < 2:
            continue
        line: Row = {"scene": problem.removeprefix("3x3 ")}
        for name, row in by.items():
            line |= {f"{name}: outcome": row["outcome"], f"{name}: s": row["seconds"]}
            line |= {f"{name}: iterations": row["iterations"], f"{name}: factorisations": row["factorisations"]}
        if all(row["outcome"] == "converged" for row in by.values()):
            sddp, single = by["sddp"], by["single-step"]
            line["seconds, single-step / sddp"] = f"{float(single['seconds']) / float(sddp['seconds']):.2f}"
            line["energy apart"] = f"{abs(float(single['energy']) / float(sddp['energy']) - 1):.0e}"
        lines.append(line)
    return lines


def shown(row: Row) -> Row:
    """Return what is shown of a tissue row."""
    line = {name: row[name] for name in ("problem", "method", "order", "size", "parted", "seconds")}
    return line | {what: f"{row[what]:.1e}" for what in WHAT if what in row}


def costs(row: Row) -> Row:
    """Return what a run took."""
    names = ("problem", "method", "order", "size", "strategy", "unknowns", "iterations", "factorisations")
    line = {name: row[name] for name in (*names, "seconds", "wall_seconds", "peak_mb", "certified")}
    return line | {name: value for name, value in json.loads(row["phases"] or "{}").items()}


def grouped(rows: Iterable[Row], names: tuple[str, ...]) -> dict[tuple[str, ...], list[Row]]:
    """Return rows by what they have in common."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(str(row[name]) for name in names), []).append(row)
    return groups


def markdown(rows: list[Row], title: str) -> str:
    """Return rows as a Markdown table; rows may lack entries."""
    if not rows:
        return f"## {title}\n\nNothing ran.\n"
    names = list(dict.fromkeys(name for row in rows for name in row))
    lines = [[row.get(name, "") for name in names] for row in rows]
    return f"## {title}\n\n{tables.markdown(names, lines)}\n"


def work_precision(exact: list[Row], tissues: list[Row], path: Path) -> None:
    """Draw the worst error over seconds, a line a method and order, and the Pareto front."""
    panels = {name: choices(rows) for name, rows in groups_of(exact, tissues).items()}
    panels = {name: lines for name, lines in panels.items() if lines}
    columns = min(3, len(panels))
    count = -(-len(panels) // columns)
    size = 4.6 * columns, 3.8 * count
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(count, columns, squeeze=False)
    for axis, (name, lines) in zip(axes.flat, panels.items(), strict=False):
        for (method, order), mine in grouped(lines, ("method", "order")).items():
            mine = sorted(mine, key=lambda line: -line["size"])
            seconds, error = zip(*((line["seconds"], line["error"]) for line in mine), strict=True)
            look = {"color": COLOURS.get(method, "0.5"), "label": f"{method}, order {order}"}
            axis.loglog(seconds, error, STYLES[int(order)], marker="o", ms=4, **look)
        best = upper_end(lines)
        seconds, error = zip(*((line["seconds"], line["error"]) for line in best), strict=True)
        axis.loglog(seconds, error, "ks", mfc="none", ms=9, label="Pareto front")
        axis.set(xlabel="processor seconds", ylabel="largest relative error", title=name)
        axis.grid(alpha=0.3)
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.xaxis.set_major_formatter(ScalarFormatter())
        axis.xaxis.set_minor_formatter(NullFormatter())
    for axis in list(axes.flat)[len(panels) :]:
        axis.set_visible(False)
    legends = [axis.get_legend_handles_labels() for axis in axes.flat]
    handles = {label: handle for drawn in legends for handle, label in zip(*drawn, strict=True)}
    figure.legend(handles.values(), handles, loc="outside right center", fontsize=8, handlelength=3)
    figure.savefig(path, dpi=140)
