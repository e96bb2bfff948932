"""`ngcell cases`: the cases that come with ngcell."""

from __future__ import annotations

import click


@click.command(short_help="List the cases that come with ngcell.")
def cases() -> None:
    """List the cases that come with ngcell; `solve` and `check` take their names."""
    from ngcell.scene import case_title, shipped_cases

    files = shipped_cases()
    width = max(map(len, files), default=0)
    for name, file in files.items():
        click.echo(f"{name:{width}}  {case_title(file)}")
