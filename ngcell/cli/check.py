"""`ngcell check CASE`: what would be solved, without solving it."""

from __future__ import annotations

from pathlib import Path

import click

from ngcell.cli.arguments import case_argument, picture_file, set_option
from ngcell.cli.summary import table_lines


@click.command(short_help="Build a case without solving it; draw it.")
@case_argument
@set_option
@click.option(
    "--picture",
    type=click.Path(dir_okay=False, path_type=Path),
    callback=picture_file,
    help="Draw cells, walls and supports into this PNG file.",
)
def check(case: str, overrides: tuple[str, ...], picture: Path | None) -> None:
    """Build CASE without solving it: cells, mesh, bodies, pairs, initial gaps and overlaps, unknowns.

    CASE is a TOML file or the name of a case that comes with ngcell.
    """
    from ngcell.scene import read_case

    scene = read_case(case, overrides)

    from ngcell.run import inspect

    told = {name: value for name, value in inspect(scene).items() if (name, value) != ("error_not_estimated", None)}
    for line in table_lines(told):
        click.echo(line)
    if picture is not None:
        from ngcell.run import draw_layout

        click.echo(str(draw_layout(scene, picture)))
