"""`ngcell schema`: what a case file may say, for editors and other programs."""

from __future__ import annotations

import json

import click


@click.command()
def schema() -> None:
    """Print the JSON schema of a case file."""
    from ngcell.scene import schema as case_schema

    click.echo(json.dumps(case_schema(), indent=2))
