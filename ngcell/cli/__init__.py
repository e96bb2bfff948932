"""The command `ngcell`: one file for each verb; the only package that prints.

NGSolve and the other large libraries are imported inside the verbs, so that help and usage errors answer at once.
"""

from __future__ import annotations

import click

from ngcell import __version__
from ngcell.cli.cases import cases
from ngcell.cli.check import check
from ngcell.cli.schema import schema
from ngcell.cli.solve import solve
from ngcell.cli.view import view
from ngcell.errors import NgcellError

__all__ = ["ngcell"]


class ErrorAnsweringGroup(click.Group):
    """A group of verbs that ends with the message and the exit code of an error of ngcell."""

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except NgcellError as error:
            click.echo(str(error), err=True)
            ctx.exit(error.exit_code)


@click.group(cls=ErrorAnsweringGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="ngcell")
def ngcell() -> None:
    """Simulate tissues of hollow cells that press, slide and part.

    Exit codes: 0 converged and certified, 2 wrong usage, 3 wrong case, 4 not converged, not certified or not written.
    """


for verb in (solve, check, view, cases, schema):
    ngcell.add_command(verb)
