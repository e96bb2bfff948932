"""Arguments that several verbs take."""

from __future__ import annotations

from pathlib import Path

import click


def _with_value(ctx: click.Context, parameter: click.Parameter, overrides: tuple[str, ...]) -> tuple[str, ...]:
    for override in overrides:
        if not override.partition("=")[1]:
            raise click.BadParameter(f"{override!r} is not key=value, as in --set tissue.wall=0.1")
    return overrides


def picture_file(ctx: click.Context, parameter: click.Parameter, file: Path | None) -> Path | None:
    """Return the file of a picture; refuse a name that is none of a PNG."""
    if file is not None and file.suffix.lower() != ".png":
        raise click.BadParameter(f"{str(file)!r} is no name of a picture; allowed: a file that ends with .png")
    return file


case_argument = click.argument("case")

set_option = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    callback=_with_value,
    help="Set a key of the case, such as tissue.wall=0.1. May be given again.",
)
