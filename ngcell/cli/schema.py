"""`ngcell schema`: what a case file or a study may say, for editors and other programs."""

from __future__ import annotations

import json

import click


@click.command()
@click.option("--study", is_flag=True, help="That of a study, which `ngcell sweep` takes, instead.")
def schema(study: bool) -> None:
    """Print the JSON schema of a case file."""
    from ngcell.scene.vocabulary import schema as case_schema
    from ngcell.scene.vocabulary import study_schema

    click.echo(json.dumps(study_schema() if study else case_schema(), indent=2))
