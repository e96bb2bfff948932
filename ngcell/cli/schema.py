"""`ngcell schema`: what a case file or a study may say, for editors and other programs."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command(short_help="Print what a case may say, as JSON schema.")
@click.option("--study", is_flag=True, help="That of a study, which `ngcell sweep` takes, instead.")
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write it to this file instead, and tell the line by which a case file names it to editors.",
)
def schema(study: bool, out: Path | None) -> None:
    """Print the JSON schema of a case file.

    A case file whose first line is "#:schema FILE" is completed and checked by editors as it is written.
    """
    from ngcell.scene.editor_schema import case_schema, study_schema

    text = json.dumps(study_schema() if study else case_schema(), indent=2)
    if out is None:
        click.echo(text)
        return
    out.write_text(f"{text}\n", encoding="utf-8")
    click.echo(f"first line of a {'study' if study else 'case'} file beside it: #:schema {out.name}")
