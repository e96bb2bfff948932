"""A run in some ten lines: certified or not, how sure its numbers are, what came apart, and where all of it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite, nan
from pathlib import Path
from shlex import quote
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from ngcell.cli.pace import duration
from ngcell.results.verdict import (
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

if TYPE_CHECKING:
    from ngcell.recording import Recording

#: Length of a line.
_WIDTH = 100


def summary_lines(recording: Recording, folder: Path) -> Iterator[str]:
    """Yield the lines that the terminal shows of a finished run."""
    summary = recording.summary
    yield f"certified    {'yes' if recording.certified else 'NO'}: {headline(summary).partition(': ')[2]}"
    for check in checks_not_passed(summary):
        where = f" in {check.place}" if check.place else ""
        advice = f"; to try: {check.advice}" if check.advice else ""
        worst = "is no number" if check.worst is None or not isfinite(check.worst) else _shown(check.worst)
        yield f"  {_words(check.name)} {worst}, limit {_shown(check.limit)}{where}{advice}"
    yield from number_lines(summary)
    apart = came_apart(summary)
    if apart:
        yield from wrap(f"came apart   {apart}", _WIDTH, subsequent_indent=" " * 13, break_on_hyphens=False)
    yield from rupture_lines(summary.get("rupture", {}))
    yield from expected_lines(summary.get("expected", ()))
    yield from stiffer_lines(summary.get("stiffer_penalty", {}))
    yield from finer_lines(summary.get("finer_mesh", {}))
    seconds = (summary.get("seconds") or {}).get("on_the_clock")
    took = "" if seconds is None else f", after {duration(seconds)}"
    yield f"results      {folder}{took}; on one page: ngcell report {quote(str(folder))}"


def number_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield the numbers of the last step with their estimated errors, or why these are not known."""
    if not summary.get("last_step"):
        return
    remark = error_remark(summary) or how_estimated(summary)
    refused = "" if summary.get("certified", True) else "NOT CERTIFIED; "
    yield f"how sure     {refused}{last_load(summary)}; {remark}"
    for name, (value, error) in last_numbers(summary).items():
        yield f"  {_words(name):13}  {with_error(value, error)}"
    if slid := slid_remark(summary):
        yield f"  {slid}"


def rupture_lines(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield where walls would rupture and separate, and how cells end; nothing where it is not known what walls bear.
    """
    if not table:
        return
    load, first = table["load"], table["first_separation"]
    if load is None:
        largest = with_error(table["largest_utilisation"], table["largest_utilisation_error"] or nan)
        yield f"rupture      of no wall; largest utilisation {largest}"
    elif load["between"][0] == load["between"][1]:
        yield f"rupture      of cell {load['cell']} at load factor {load['load_factor']:.4g} or before"
    else:
        told = with_error(load["load_factor"], load["error"])
        untold = "" if isfinite(load["error"]) else ", error of the mesh not estimated"
        yield f"rupture      of cell {load['cell']} at load factor {told}{untold}"
    yield f"separation   {'of no walls' if first is None else f'from load factor {first:.4g} on'}"
    yield f"cells        {', '.join(f'{len(cells)} {end}' for end, cells in table['cells'].items())}"
    work = (f"{_shown(table[f'work_of_{what}'])} of {what}" for what in ("separation", "rupture"))
    yield f"work         {', '.join(work)}"


def expected_lines(findings: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield measured beside expected numbers, as a table where one is not met; nothing if the case expects none."""
    if not findings:
        return
    missed = sum(not finding["passed"] for finding in findings)
    if not missed:
        names = ", ".join(dict.fromkeys(_words(finding["quantity"]) for finding in findings))
        yield f"expected     met: {names}"
        return
    yield f"expected     {missed} of {len(findings)} NOT MET"
    places = [f"{finding['quantity']} {finding['place']}".rstrip() for finding in findings]
    width = max(map(len, places))
    yield f"  {'':{width}}  {'load':>8}  {'measured':>12}  {'expected':>12}  {'deviation':>10}  {'tolerance':>10}"
    for place, finding in zip(places, findings, strict=True):
        yield (
            f"  {place:{width}}  {finding['load_factor']:8.4g}  {finding['measured']:12.6g}  "
            f"{finding['expected']:12.6g}  {finding['deviation']:+10.1e}  {finding['tolerance']:10.1e}"
            f"{'' if finding['passed'] else '  not met'}"
        )


def stiffer_lines(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield how results change with a stiffer penalty; nothing if that was not asked for."""
    return _verified_lines("penalty", table, "with penalty terms {stiffness_factor:.4g} times as stiff", "stiffer")


def finer_lines(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield how results change with a finer mesh; nothing if that was not asked for."""
    return _verified_lines("mesh", table, "with elements of order {order}", "finer")


def _verified_lines(what: str, table: Mapping[str, Any], how: str, other: str) -> Iterator[str]:
    if "failed" in table:
        yield f"{what:12} not verified: {table['failed']}"
        return
    rows = {name: row for name, row in table.items() if isinstance(row, Mapping)}
    if rows:
        yield f"{what:12} the last level {how.format(**table)}"
    width = max(map(len, rows), default=0)
    for name, row in rows.items():
        change = "" if row["change"] is None else f"{row['change']:+10.1e}"
        told = "" if row["change"] is None or "error" not in row else f"  ±{row['error'] / abs(row['meant']):8.1e}"
        yield f"  {_words(name):{width}}  {_shown(row['meant']):>10}  {_shown(row[other]):>10}  {change}{told}"


def table_lines(table: Mapping[str, Any], indent: int = 0) -> Iterator[str]:
    """Yield a line for each entry of a table, its inner tables indented below their name."""
    width = max((len(name) for name, value in table.items() if not isinstance(value, Mapping)), default=0)
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield f"{' ' * indent}{_words(name)}"
            yield from table_lines(value, indent + 2)
        else:
            yield f"{' ' * indent}{_words(name):{width}}  {_shown(value)}"


def _words(name: object) -> str:
    return str(name).replace("_", " ")


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if value is None:
        return "none"
    if isinstance(value, Mapping):
        return ", ".join(f"{_words(name)} {_shown(entry)}" for name, entry in value.items())
    if isinstance(value, (list, tuple)):
        return ("; " if value and isinstance(value[0], Mapping) else ", ").join(map(_shown, value))
    return str(value)
