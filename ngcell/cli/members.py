"""Members of a case on the terminal: their progress, and for each number how much of it is known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, isinf
from pathlib import Path
from typing import TYPE_CHECKING

from ngcell.results.verdict import with_error

if TYPE_CHECKING:
    from ngcell.ensemble import Ensemble
    from ngcell.results.spread import Spread

#: Numbers whose errors can be estimated, and those that the terminal shows of the last level; `spread.csv` has all.
_ESTIMATED = ("energy", "plate_force", "contact_force", "mean_gap", "largest_gap")
_SHOWN = (*_ESTIMATED, "parted_pairs", "components")


def holds_members(folder: Path, resume: Path | None) -> bool:
    """Return whether what is to be resumed in a folder are members of a case."""
    if resume is None:
        return False
    from ngcell.export.summary import MEMBERS, read_summary

    return MEMBERS in read_summary(folder)


def members_lines(ensemble: Ensemble) -> Iterator[str]:
    """Yield the lines that the terminal shows of all members."""
    choice, members = ensemble.choice, ensemble.members
    counted = sum(member.certified for member in members)
    differ = "other seeds of the tissue" if isinf(ensemble.share) else f"spread {ensemble.share:g}"
    seeds = f"seeds {choice.seeds[0]} to {choice.seeds[-1]}"
    yield f"members      {counted} of {len(members)} certified, {seeds}, {differ}"
    for member in members:
        if not member.certified:
            yield f"  seed {member.seed}: {member.outcome}"
    yield from last_level_lines(ensemble.spreads)
    yield f"results      {ensemble.out}"


def last_level_lines(spreads: Sequence[Spread]) -> Iterator[str]:
    """Yield the numbers of the last level that members have reached."""
    last = [row for row in spreads if row.level == spreads[-1].level]
    if last:
        yield f"load factor  {last[0].load_factor:.6g}"
    for row in last:
        if row.number in _SHOWN:
            yield f"  {spread_line(row)}"
            if row.remark:
                yield f"  {'':13}  known to {100 * row.known_to:.2g} % only: {row.remark}"


def spread_line(row: Spread) -> str:
    """Return a number with its error and its spread."""
    shown = f"{row.number.replace('_', ' '):13} = {with_error(row.mean, row.error)}"
    if isfinite(row.error):
        shown += " (mesh)"
    elif row.number in _ESTIMATED:
        shown += " (mesh not estimated)"
    if not isfinite(row.deviation):
        return f"{shown}, of one member: no spread"
    spread = f"{100 * row.relative:.2g} %" if abs(row.mean) > row.deviation else f"{row.deviation:.2g}"
    return f"{shown}, spread over {row.members} members {spread} ({row.smallest:.4g} to {row.largest:.4g})"
