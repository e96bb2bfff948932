"""The one way in which tools are called: a group for each package, a module for each of its commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

import click

from ngcell.errors import NgcellError

_SETTINGS = {"help_option_names": ["-h", "--help"], "terminal_width": 120}


class Commands(click.Group):
    """A group whose commands are modules of a package, imported when they are asked for.

    Parameters
    ----------
    package : str
        Full name of the package.
    names : iterable of str
        Names of the commands; each module holds a click command `command`.
    text : str
        What the group is for.
    """

    def __init__(self, package: str, names: Iterable[str], text: str | None) -> None:
        super().__init__(help=text, context_settings=_SETTINGS)
        self._package, self._names = package, sorted(names)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return self._names

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except NgcellError as error:
            raise click.ClickException(str(error)) from error

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self._names:
            return None
        try:
            found: click.Command = import_module(f"{self._package}.{cmd_name.replace('-', '_')}").command
        except ModuleNotFoundError as missing:
            return _lacking(cmd_name, missing)
        return found


def _lacking(name: str, missing: ModuleNotFoundError) -> click.Command:
    """Return a command that says which library it lacks."""
    needed = f'needs {missing.name}, which is not installed: pip install ".[test]" brings all that tools need'

    def refuse() -> None:
        raise click.ClickException(f"{name} {needed}")

    return click.Command(name, callback=refuse, short_help=f"({needed})")


def described(text: str | None) -> Callable[[Callable[..., Any]], click.Command]:
    """Return the decorator that makes a command whose help is the text of its module, line by line."""
    paragraphs = (text or "").strip().split("\n\n")
    kept = "\n\n".join(f"\b\n{paragraph}" for paragraph in paragraphs)
    return click.command(help=kept, short_help=" ".join(paragraphs[0].split()), context_settings=_SETTINGS)
