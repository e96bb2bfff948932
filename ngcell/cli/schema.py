"""`ngcell schema`: what a case file may say, for editors and other programs."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command()
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write it to this file instead, and tell the line by which a case file names it to editors.",
)
def schema(out: Path | None) -> None:
    """Print the JSON schema of a case file.

    A case file whose first line is "#:schema FILE" is completed and checked by editors as it is written.
    """
    from ngcell.scene import schema as case_schema

    text = json.dumps(case_schema(), indent=2)
    if out is None:
        click.echo(text)
        return
    out.write_text(f"{text}\n", encoding="utf-8")
    click.echo(f"first line of a case file beside it: #:schema {out.name}")
