"""Arguments that several verbs take."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from pathlib import Path

import click
from click.shell_completion import CompletionItem


def _with_value(ctx: click.Context, parameter: click.Parameter, overrides: tuple[str, ...]) -> tuple[str, ...]:
    for override in overrides:
        if not override.partition("=")[1]:
            raise click.BadParameter(f"{override!r} is not key=value, as in --set tissue.wall=0.1")
    return overrides


def finite(ctx: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Return a number; refuse one that no range refuses, and that is none."""
    if value is not None and not isfinite(value):
        raise click.BadParameter(f"{value} is no number to reckon with; allowed: a finite number > 0")
    return value


def picture_file(ctx: click.Context, parameter: click.Parameter, file: Path | None) -> Path | None:
    """Return the file of a picture; refuse a name that is none of a PNG."""
    if file is not None and file.suffix.lower() != ".png":
        raise click.BadParameter(f"{str(file)!r} is no name of a picture; allowed: a file that ends with .png")
    return file


def _case_names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the names of cases that come with ngcell, which shells offer besides files."""
    from ngcell.scene.catalogue import shipped_cases

    return _files_and(shipped_cases(), incomplete)


def study_names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the names of studies that come with ngcell, which shells offer besides files."""
    from ngcell.scene.catalogue import shipped_studies

    return _files_and(shipped_studies(), incomplete)


def _files_and(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return [CompletionItem(incomplete, type="file"), *found]  # bash forgets what stands before a file


case_argument = click.argument("case", shell_complete=_case_names)
optional_case_argument = click.argument("case", required=False, shell_complete=_case_names)

set_option = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    callback=_with_value,
    help="Set a key of the case, such as tissue.wall=0.1; the value as in a case file. May be given again.",
)
