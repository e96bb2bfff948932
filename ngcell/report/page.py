"""The report: one HTML file that needs nothing else, made from result folders."""

from __future__ import annotations

import platform
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from importlib.resources import files
from pathlib import Path
from typing import Any

from ngcell import __version__
from ngcell.errors import OutputError
from ngcell.export.atomic import replace_file
from ngcell.report.overall import Part, comparison, members_part
from ngcell.report.pictures import pictures_of
from ngcell.report.rows import number
from ngcell.report.run_folder import RunFolder
from ngcell.report.sources import Source, read_source
from ngcell.report.sweep import sweep_part
from ngcell.report.view import RunView, colour_table, view_of

REPORT = "report.html"
#: Bytes that a page may have, its words and figures besides: it stays below ten megabytes.
_BUDGET = 9_000_000
#: Bytes of a cell of a table.
_CELL = 45
#: Most runs that are told in full on one page.
_IN_FULL = 6


@dataclass(frozen=True)
class Report:
    """A report that was written: its file, and one line for each thing that it lacks."""

    file: Path
    remarks: tuple[str, ...]


def write_report(folders: Sequence[Path], out: Path | None = None) -> Report:
    """Write a report of runs, of members or of a sweep into one HTML file.

    Parameters
    ----------
    folders : sequence of Path
        Result folders: each of a run, of members of a case, or of a sweep.
    out : Path, optional
        The file; by default `report.html` in the folder, and in the working folder if there are several.

    Raises
    ------
    OutputError
        If none of the folders can be read, or the file cannot be written.
    """
    sources, unread = [], []
    for folder in folders:
        try:
            sources.append(read_source(Path(folder)))
        except OutputError as error:
            unread.append(str(error))
    if not sources:
        raise OutputError("\n".join(unread))
    file = Path(out) if out is not None else (Path(folders[0]) if len(folders) == 1 else Path()) / REPORT
    page, remarks = _page(sources, unread)
    replace_file(file, page.encode())
    return Report(file, tuple([*unread, *remarks]))


def _page(sources: Sequence[Source], unread: Sequence[str]) -> tuple[str, list[str]]:
    """Return the text of the page, and what it lacks."""
    overall: list[Part] = []
    for place, source in enumerate(sources):
        if source.kind == "members":
            overall.append(members_part(source, f"members-{place}"))
        elif source.kind == "sweep":
            overall.append(sweep_part(source, f"sweep-{place}"))
    runs = [run for source in sources if source.kind == "run" for run in source.runs]
    if len(runs) > 1:
        overall.append(comparison(runs))
    told = _told_in_full(sources)
    budget = (_BUDGET - sum(map(_other_bytes, told))) // max(len(told), 1)
    views = [view_of(run, f"run-{place}", budget) for place, run in enumerate(told)]
    remarks = [f"{view.name}: {line}" for view in views for line in view.missing]
    remarks += [f"{view.name}: {line}" for view in views if view.player for line in view.player.left_out]
    drawn = [view for view in views if view.player]
    certified = not unread and all(source.certified for source in sources)
    page = _template().render(
        title=_title(sources),
        lead=_lead(sources),
        certified=certified,
        unread=unread,
        overall=overall,
        runs=views,
        beside=drawn if len(drawn) > 1 else [],
        contents=_contents(overall, views),
        version=__version__,
        libraries=libraries(),
        source=", ".join(source.path.resolve().name for source in sources),
        colours=b64encode(colour_table().tobytes()).decode(),
        style=_text("style.css"),
        tables_script=_text("tables.js"),
        player_script=_text("player.js"),
    )
    return page, remarks


def _other_bytes(run: RunFolder) -> int:
    """Return what pictures and tables of a run take, about [byte]."""
    pictures = sum(len(picture.source) for picture in pictures_of(run))
    return pictures + _CELL * (13 * len(run.walls) + 6 * len(run.cells))


def _told_in_full(sources: Sequence[Source]) -> list[RunFolder]:
    """Return runs that are told in full: those that were named, and the first of members or of a sweep."""
    named = [run for source in sources if source.kind == "run" for run in source.runs]
    firsts = [source.runs[0] for source in sources if source.kind != "run" and source.runs]
    return (named + firsts)[:_IN_FULL]


def _title(sources: Sequence[Source]) -> str:
    titles = list(dict.fromkeys(source.title for source in sources))
    return titles[0] if len(titles) == 1 else " | ".join(titles[:3]) + (" | …" if len(titles) > 3 else "")


def _lead(sources: Sequence[Source]) -> str:
    if len(sources) > 1:
        return f"{len(sources)} results side by side."
    return {"run": "Result of a run", "members": "Members of a case", "sweep": "A sweep"}[sources[0].kind] + (
        f", from {sources[0].path.resolve().name}."
    )


def _contents(overall: Sequence[Part], views: Sequence[RunView]) -> list[tuple[str, str]]:
    """Return the parts of the page that its first lines link to."""
    found = [(part.key, part.title) for part in overall]
    if len(views) > 1 or overall:
        found += [("beside", "Deformed")] if sum(view.player is not None for view in views) > 1 else []
        return found + [(view.key, view.name) for view in views]
    (view,) = views
    parts: list[tuple[str, str, Any]] = [
        ("tissue", "Tissue", view.player), ("curves", "Curves", view.figures), ("pictures", "Pictures", view.pictures),
        ("asked", "Asked", view.asked), ("certificate", "Certificate", view.checks or view.expected),
        ("walls", "Walls and cells", view.walls or view.cells), ("case", "Case", view.case_text),
    ]  # fmt: skip
    return [(view.key, "Verdict"), *((f"{view.key}-{key}", words) for key, words, there in parts if there)]


def libraries() -> str:
    """Return the versions of what reads results and draws."""
    names = ("numpy", "pyvista", "matplotlib")
    return ", ".join([f"Python {platform.python_version()}", *(f"{name} {metadata.version(name)}" for name in names)])


@cache
def _template() -> Any:
    from jinja2 import Environment, PackageLoader

    environment = Environment(
        loader=PackageLoader("ngcell.report"), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["number"] = number
    return environment.get_template("page.html")


def _text(name: str) -> Any:
    from markupsafe import Markup

    return Markup((files("ngcell.report") / "templates" / name).read_text(encoding="utf-8"))
