"""`ngcell export-febio CASE --out FILE.feb`: the same scene for FEBio."""

from __future__ import annotations

from pathlib import Path

import click

from ngcell.cli.arguments import case_argument, set_option
from ngcell.cli.summary import table_lines


def _deck_file(ctx: click.Context, parameter: click.Parameter, file: Path) -> Path:
    if file.suffix.lower() != ".feb":
        raise click.BadParameter(f"{str(file)!r} is no name of a deck; allowed: a file that ends with .feb")
    return file


@click.command("export-febio", short_help="Write a planar tissue as a FEBio deck.")
@case_argument
@set_option
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    callback=_deck_file,
    help="File of the deck, which ends with .feb.",
)
def export_febio(case: str, overrides: tuple[str, ...], out: Path) -> None:
    """Write CASE, a planar tissue, as a FEBio 4 deck: mesh, materials, contact pairs, supports, pressures or fluids,
    steps.

    CASE is a TOML file or the name of a case that comes with ngcell. What the deck cannot say ends the export with one
    line, or is told after the numbers.
    """
    from ngcell.scene import read_case

    scene = read_case(case, overrides)

    from ngcell import run

    for line in table_lines(run.export_febio(scene, out)):
        click.echo(line)
