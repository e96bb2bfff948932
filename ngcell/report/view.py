"""A run as the page tells it: words, tables, figures and pictures, ready for the template."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

import numpy as np

from ngcell.export.curves import released_steps
from ngcell.report.charts import Figure, figures_of
from ngcell.report.pictures import Picture, pictures_of
from ngcell.report.player import Player, player_of
from ngcell.report.rows import Table, checks_table, expected_table, levels_table, number, records_table
from ngcell.report.run_folder import RunFolder, case_table
from ngcell.results.record import StepRecord
from ngcell.results.verdict import (
    FailedCheck,
    came_apart,
    checks_not_passed,
    error_remark,
    headline,
    how_estimated,
    last_load,
    last_numbers,
    slid_remark,
    with_error,
)

_HINT_PLANE = (
    "Cells whose lumen is hatched and whose outline is dashed are held by nothing. Zoom with the buttons or + and -, "
    "move by dragging or with the arrow keys; the pointer reads values."
)
_HINT_SOLID = "Rotate by dragging or with the arrow keys, zoom with the buttons or + and -; the pointer reads values."


@dataclass(frozen=True)
class Verdict:
    """What is said first."""

    certified: bool
    lines: Sequence[str]
    failed: Sequence[FailedCheck] = ()


@dataclass(frozen=True)
class Told:
    """A number of the last level, and its estimated error in words."""

    title: str
    value: str
    error: str


@dataclass
class RunView:
    """Everything that the page shows of one run, by the names that the template uses."""

    key: str
    name: str
    title: str
    certified: bool
    verdict: Verdict
    numbers: Sequence[Told] = ()
    last_level: str = ""
    apart: str = ""
    missing: Sequence[str] = ()
    player: Player | None = None
    hint: str = ""
    ramp: str = ""
    figures: Sequence[Figure] = ()
    of_errors: str = ""
    levels: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()
    source: str = ""
    asked: Sequence[tuple[str, str]] = ()
    checks: Sequence[Table] = ()
    expected: Sequence[Table] = ()
    walls: Sequence[Table] = ()
    cells: Sequence[Table] = ()
    case_text: str = ""
    effort: Sequence[tuple[str, str]] = field(default_factory=list)


def view_of(run: RunFolder, key: str, budget: int) -> RunView:
    """Return what the page shows of a run.

    Parameters
    ----------
    run : RunFolder
        What its folder holds.
    key : str
        Name of the run in the page, unlike any other's.
    budget : int
        Bytes that its deformed tissue may have.
    """
    player = player_of(run.snapshots(), budget)
    player.data |= {"certified": run.certified} if player.data else {}
    refused = [row.step for row in run.history if not row.certified]
    released = released_steps(run.history)
    table = case_table(run.case_text)
    return RunView(
        key=key,
        name=run.name,
        title=run.title,
        certified=run.certified,
        verdict=verdict_of(run.summary),
        numbers=told_numbers(run.summary),
        last_level=_last_level(run.summary),
        apart=came_apart(run.summary),
        missing=run.missing,
        player=player if player.data else None,
        hint=_HINT_SOLID if player.data.get("solid") else _HINT_PLANE,
        ramp=ramp(),
        figures=figures_of({run.name: released}, {run.name: run.certified}, key=key),
        of_errors="Bands and bars are estimated errors." if _errors_known(released) else "Errors are not estimated.",
        levels=levels_table(key, released),
        pictures=list(pictures_of(run)),
        source=str(table.get("source") or ""),
        asked=list(asked(table)),
        checks=checks_table(key, run.summary),
        expected=expected_table(key, run.summary),
        walls=records_table(f"{key}-wall-rows", "Walls", run.walls, refused=refused),
        cells=records_table(f"{key}-cell-rows", "Cells", run.cells, refused=refused),
        case_text=run.case_text,
        effort=list(_effort(run.summary)),
    )


def _errors_known(history: Iterable[StepRecord]) -> bool:
    return any(isfinite(row.energy_error) for row in history)


#: What was asked to be verified, and how.
_VERIFIED = {"stiffer_penalty": "by a stiffer penalty", "finer_mesh": "on a finer mesh"}


def verdict_of(summary: Mapping[str, Any]) -> Verdict:
    """Return the verdict of a run in words."""
    said = headline(summary).partition(": ")[2] or headline(summary)
    lines = [said[:1].upper() + said[1:] + "."]
    remark = error_remark(summary)
    if summary.get("last_step") and remark:
        lines.append(remark[:1].upper() + remark[1:] + ".")
    elif summary.get("accuracy"):
        lines.append(f"Asked for a relative error of at most {summary['accuracy']:g}.")
    if slid := slid_remark(summary):
        lines.append(slid[:1].upper() + slid[1:] + ".")
    for key, by in _VERIFIED.items():
        if failed := (summary.get(key) or {}).get("failed"):
            lines.append(f"Not verified {by}: {failed}.")
    return Verdict(bool(summary.get("certified")), lines, checks_not_passed(summary))


def told_numbers(summary: Mapping[str, Any]) -> list[Told]:
    """Return the numbers of the last level, each with its error in words, and by how much a finer mesh moves it."""
    found, finer = [], {} if summary.get("error_not_estimated") else summary.get("finer_mesh") or {}
    for name, (value, error) in last_numbers(summary).items():
        _, _, share = with_error(value, error).partition(" ± ")
        change = (finer.get(name) or {}).get("change")
        moves = "" if change is None else f", {100 * change:+.2g} % on the finest mesh"
        told = f"± {share}" if share else "error not known"
        found.append(Told(name.replace("_", " "), number(value), f"{told}{moves}"))
    return found


def _last_level(summary: Mapping[str, Any]) -> str:
    load = last_load(summary)
    known = "" if error_remark(summary) else f", {how_estimated(summary)}"
    return f"At the last level ({load}){known}:" if load else ""


def asked(table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield each section of a case and what it says."""
    plain = {key: value for key, value in table.items() if not isinstance(value, (Mapping, list))}
    for key, value in plain.items():
        if key not in ("title", "source") and value is not None:
            yield key, _said(value)
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield key, " · ".join(f"{name} {_said(entry)}" for name, entry in value.items())
        elif isinstance(value, list) and value and key != "expected":
            yield key, "; ".join(map(_said, value))


def _said(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_said(entry)}" for name, entry in value.items())
    if isinstance(value, list):
        words = ", ".join(map(_said, value[:12]))
        return f"({words}{', …' if len(value) > 12 else ''})"
    return "infinite" if value == inf else number(value)


def _effort(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield how large the scene was, what its solution took, and by which versions."""
    for key, title in (("bodies", "bodies"), ("facing_pairs", "pairs of facing walls")):
        if summary.get(key) is not None:
            yield title, str(summary[key])
    meshes: Iterable[Mapping[str, Any]] = summary.get("meshes") or ()
    told = ", ".join(f"order {one.get('order')} with {one.get('unknowns')} unknowns" for one in meshes)
    if told or summary.get("unknowns"):
        yield "meshes", told or f"{summary['unknowns']} unknowns"
    if summary.get("factorisations") is not None:
        yield "iterations", f"{summary.get('iterations')}, with {summary['factorisations']} factorisations"
    seconds = summary.get("seconds") or {}
    if seconds.get("on_the_clock") is not None:
        yield "time", f"{seconds['on_the_clock']:.0f} s, of the processor {seconds.get('processor') or 0.0:.0f} s"
    versions = summary.get("versions") or {}
    yield "versions", ", ".join(f"{name} {one}" for name, one in versions.items()) or "the run has not written them"


def colour_table() -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Return the colours of fields from the smallest to the largest value, shape (256, 3): darker is less."""
    from matplotlib import colormaps

    return np.asarray(np.round(255 * colormaps["viridis"](np.linspace(0, 1, 256))[:, :3]), dtype=np.uint8)


def ramp() -> str:
    """Return the same colours as CSS says them."""
    return ", ".join("#{:02x}{:02x}{:02x}".format(*colour) for colour in colour_table()[::15])
