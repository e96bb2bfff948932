"""`ngcell check CASE`: what would be solved, without solving it."""

from __future__ import annotations

import click

from ngcell.cli.arguments import case_argument, set_option
from ngcell.cli.summary import table_lines


@click.command()
@case_argument
@set_option
def check(case: str, overrides: tuple[str, ...]) -> None:
    """Build CASE without solving it: mesh, bodies, pairs, initial gaps and overlaps, unknowns.

    CASE is a TOML file or the name of a case that comes with ngcell.
    """
    from ngcell.scene import read_case

    scene = read_case(case, overrides)

    from ngcell.run import inspect

    for line in table_lines(inspect(scene)):
        click.echo(line)
