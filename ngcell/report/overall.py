"""What a page tells of several runs together: side by side, or as members of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ngcell.export.curves import released_steps
from ngcell.report.charts import Figure, figures_of
from ngcell.report.pictures import Picture, pictures_of
from ngcell.report.rows import Cell, Row, Table, cell_of, columns_of, value_of
from ngcell.report.run_folder import RunFolder, case_table
from ngcell.report.sources import Source
from ngcell.report.view import Verdict, asked
from ngcell.results.verdict import came_apart, headline, last_numbers, with_error


@dataclass
class Part:
    """A part of the page over several runs, by the names that the template uses."""

    key: str
    title: str
    refused: bool
    verdict: Verdict | None = None
    lines: Sequence[str] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[Figure] = ()
    pictures: Sequence[Picture] = ()
    asked: Sequence[tuple[str, str]] = ()
    figures_first: bool = False
    pictured: str = ""
    case_title: str = ""
    case_text: str = ""
    effort: Sequence[tuple[str, str]] = ()


def comparison(runs: Sequence[RunFolder]) -> Part:
    """Return runs side by side: verdicts and numbers, what their cases say differently, and their curves."""
    names = _own_names(runs)
    histories = {name: released_steps(run.history) for name, run in names.items()}
    certified = {name: run.certified for name, run in names.items()}
    return Part(
        key="comparison",
        title="Side by side",
        refused=not all(certified.values()),
        verdict=Verdict(all(certified.values()), [f"{sum(certified.values())} of {len(runs)} results are certified."]),
        tables=[_verdicts(names), *_differences(names)],
        figures=figures_of(histories, certified, key="comparison"),
    )


def _own_names(runs: Sequence[RunFolder]) -> dict[str, RunFolder]:
    """Give runs whose folders have the same name a longer one."""
    found: dict[str, RunFolder] = {}
    for run in runs:
        taken = [other for other in runs if other.path.resolve().name == run.path.resolve().name]
        name = run.name if len(taken) == 1 else "/".join(run.path.resolve().parts[-2:])
        while name in found:
            name += "'"
        run.name = name
        found[name] = run
    return found


def _verdicts(runs: Mapping[str, RunFolder]) -> Table:
    """Return a row for each run: verdict, last level, and its numbers with their errors."""
    numbers = {name: last_numbers(run.summary) for name, run in runs.items()}
    told = list(dict.fromkeys(key for row in numbers.values() for key in row))
    rows = []
    for name, run in runs.items():
        last = run.summary.get("last_step") or {}
        verdict = Cell("certified" if run.certified else "NOT CERTIFIED", None, "text")
        values = [_told(*numbers[name][key]) if key in numbers[name] else cell_of(None) for key in told]
        words = headline(run.summary).partition(": ")[2]
        apart = Cell(came_apart(run.summary) if run.certified else words, None, "long text")
        place = cell_of(last.get("plate_displacement"))
        rows.append(Row([Cell(name, None, "text"), verdict, place, *values, apart], refused=not run.certified))
    headings = ["run", "verdict", "plate displacement", *(key.replace("_", " ") for key in told), "what came apart"]
    columns = columns_of(headings, ("run", "verdict", "what came apart"))
    return Table("comparison-numbers", "Verdicts and numbers of the last level", columns, rows)


def _told(value: float, error: float | None) -> Cell:
    return Cell(with_error(value, error), value)


def _differences(runs: Mapping[str, RunFolder]) -> list[Table]:
    """Return what cases say differently; no table where they say the same."""
    said = {name: dict(asked(case_table(run.case_text))) for name, run in runs.items()}
    keys = list(dict.fromkeys(key for table in said.values() for key in table))
    different = [key for key in keys if len({table.get(key) for table in said.values()}) > 1]
    rows = [
        Row([Cell(key, None, "text"), *(Cell(table.get(key, "–"), None, "long text") for table in said.values())])
        for key in different
    ]
    columns = columns_of(headings := ["section", *said], headings)
    note = "What the cases say differently."
    return [Table("comparison-cases", "What was asked differently", columns, rows, note=note)] if rows else []


def members_part(source: Source, key: str) -> Part:
    """Return what members of a case have in common: how many are certified, their spread, and their curves."""
    histories = {run.name: released_steps(run.history) for run in source.runs}
    certified = {run.name: run.certified for run in source.runs}
    counted, asked_for = sum(certified.values()), source.summary.get("members", {}).get("count", len(certified))
    lines = [f"{counted} of {asked_for} members are certified."]
    rows = source.rows
    last = [row for row in rows if row["level"] == rows[-1]["level"]]
    spread = Table(f"{key}-spread", "Spread at the last level", columns_of(_SPREAD, ("number", "remark")), [
        Row([value_of(row.get(name)) for name in _SPREAD]) for row in last
    ])  # fmt: skip
    overall = RunFolder(source.path, source.path.name, {**source.summary, "certified": source.certified})
    return Part(
        key=key,
        title="Members",
        refused=not source.certified,
        verdict=Verdict(source.certified, [*lines, *source.unread, *_refused(source)]),
        lines=[_OF_MEMBERS] if last else [],
        tables=[spread] if last else [],
        figures=figures_of(histories, certified, key=key),
        pictures=list(pictures_of(overall)),
    )


_OF_MEMBERS = "Numbers of the last level over the members that are certified; errors are those of the mesh."
_SPREAD = ("number", "members", "mean", "deviation", "smallest", "largest", "error", "known_to", "remark")


def _refused(source: Source) -> list[str]:
    return [f"{run.name}: {headline(run.summary)}" for run in source.runs if not run.certified]
