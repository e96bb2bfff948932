"""The command `ngcell`: one file for each verb; the only package that prints.

NGSolve and the other large libraries are imported inside the verbs, so that help and usage errors answer at once.
"""

from __future__ import annotations

import sys
from typing import Any

import click

from ngcell import __version__
from ngcell.cli.cases import cases
from ngcell.cli.check import check
from ngcell.cli.export_febio import export_febio
from ngcell.cli.memory import take_small_pages
from ngcell.cli.report import report
from ngcell.cli.schema import schema
from ngcell.cli.solve import solve
from ngcell.cli.streams import give_up_stream, note, open_standard_streams
from ngcell.cli.sweep import sweep
from ngcell.cli.view import view
from ngcell.errors import NgcellError, OutputError

__all__ = ["ngcell"]


class ErrorAnsweringGroup(click.Group):
    """A group of verbs that ends with the message and the exit code of an error of ngcell."""

    def main(self, *arguments: Any, **how: Any) -> Any:
        open_standard_streams()
        take_small_pages()
        try:
            return super().main(*arguments, **how)
        except OSError as error:
            give_up_stream(1)
            what = f"cannot use {error.filename}" if error.filename else "cannot write the answer"
            note(f"{what}: {error.strerror or error}; what was written to folders is kept there")
            sys.exit(OutputError.exit_code)

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except NgcellError as error:
            note(str(error))
            ctx.exit(error.exit_code)


@click.group(cls=ErrorAnsweringGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="ngcell")
def ngcell() -> None:
    """Simulate tissues of hollow cells that press, slide and part.

    \b
    A first run, of some ten seconds; then look at out/first/tissue.png:
      ngcell solve shear-empty-3x3 --set accuracy=0.1 --set load.levels=2 --out out/first
    On one page, out/first/report.html:
      ngcell report out/first
    What a command does and takes: ngcell COMMAND --help

    Exit codes: 0 converged and certified, 2 wrong usage, 3 wrong case, 4 not converged, not certified or not written.
    """


for verb in (solve, check, sweep, view, report, export_febio, cases, schema):
    ngcell.add_command(verb)
