"""`ngcell view DIR`: show the result of a run."""

from __future__ import annotations

from pathlib import Path

import click

from ngcell.cli.arguments import finite, picture_file


@click.command(short_help="Show the deformed tissue of a run.")
@click.argument("folder", metavar="DIR", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--screenshot",
    type=click.Path(dir_okay=False, path_type=Path),
    callback=picture_file,
    help="Write a picture to this PNG file instead of opening a window.",
)
@click.option(
    "--clip",
    type=click.FloatRange(0, 1, min_open=True),
    callback=finite,
    help="Cut three-dimensional bodies off above this share of their height.",
)
def view(folder: Path, screenshot: Path | None, clip: float | None) -> None:
    """Show the deformed tissue at the last snapshot of the run in DIR."""
    from ngcell.export import show

    picture = show(folder, screenshot=screenshot, clip=clip)
    if picture is not None:
        click.echo(str(picture))
