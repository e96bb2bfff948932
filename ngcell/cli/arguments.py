"""Arguments that several verbs take."""

from __future__ import annotations

import click


def _with_value(ctx: click.Context, parameter: click.Parameter, overrides: tuple[str, ...]) -> tuple[str, ...]:
    for override in overrides:
        if not override.partition("=")[1]:
            raise click.BadParameter(f"{override!r} is not key=value, as in --set tissue.wall=0.1")
    return overrides


case_argument = click.argument("case")

set_option = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    callback=_with_value,
    help="Set a key of the case, such as tissue.wall=0.1. May be given again.",
)
