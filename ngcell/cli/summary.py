"""A run in a few lines of text: outcome, certificate, expected numbers, folder of the results."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import hypot, isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ngcell.recording import Recording


def summary_lines(recording: Recording, folder: Path) -> Iterator[str]:
    """Yield the lines that the terminal shows of a finished run."""
    yield f"outcome      {recording.outcome}"
    passed = recording.certified or _missed_expected_only(recording.summary)
    reason = recording.summary.get("error_not_estimated")
    untold = f"; error not estimated: {reason}" if reason else ""
    yield f"certificate  {'passed' if passed else 'NOT PASSED'}{untold}"
    yield from table_lines(recording.summary.get("certificate", {}), indent=2)
    yield from error_lines(recording.summary)
    yield from rupture_lines(recording.summary.get("rupture", {}))
    yield from expected_lines(recording.summary.get("expected", ()))
    yield from stiffer_lines(recording.summary.get("stiffer_penalty", {}))
    yield f"results      {folder}"


def error_lines(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield the numbers of the last step with their estimated errors; a line that says so where one is missing."""
    last = summary.get("last_step")
    if last is None or summary.get("error_not_estimated"):
        return
    if not isfinite(last["energy_error"]):
        yield "last step    its error could not be estimated"
        return
    yield "last step    with estimated errors"
    size = hypot(*(last[f"plate_force_{axis}"] for axis in "xyz"))
    rows = {name: last[name] for name in ("energy", "contact_force", "mean_gap", "largest_gap")}
    rows["plate_force"] = size
    for name, value in rows.items():
        yield f"  {_words(name):13}  {with_error(value, last[f'{name}_error'])}"


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


def with_error(value: float, error: float) -> str:
    """Return a number and its estimated error: relative, where that says something."""
    if not isfinite(error):
        return f"{value:.4g}"
    if abs(value) > error:
        return f"{value:.4g} ± {100 * error / abs(value):.1g} %"
    return f"{value:.4g} ± {error:.1g}"


def _missed_expected_only(summary: Mapping[str, Any]) -> bool:
    """Return whether every check passed, and a run is not certified for an expected number only."""
    missed = any(not finding["passed"] for finding in summary.get("expected", ()))
    return missed and not summary.get("failed_steps")


def expected_lines(findings: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a table of measured beside expected numbers; nothing if the case expects none."""
    if not findings:
        return
    missed = sum(not finding["passed"] for finding in findings)
    yield f"expected     {f'{missed} of {len(findings)} NOT MET' if missed else 'met'}"
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
    if "failed" in table:
        yield f"penalty      not verified: {table['failed']}"
    elif table:
        yield f"penalty      the last level with penalty terms {_shown(table['stiffness_factor'])} times as stiff"
        rows = {name: row for name, row in table.items() if isinstance(row, Mapping)}
        width = max(map(len, rows))
        for name, row in rows.items():
            change = "" if row["change"] is None else f"{row['change']:+10.1e}"
            yield f"  {_words(name):{width}}  {_shown(row['meant']):>10}  {_shown(row['stiffer']):>10}  {change}"


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
    return ", ".join(map(_shown, value)) if isinstance(value, (list, tuple)) else str(value)
