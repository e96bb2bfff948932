"""`ngcell report DIR...`: results as one HTML file that can be sent to somebody."""

from __future__ import annotations

from pathlib import Path

import click

from ngcell.cli.streams import note


def _html_file(ctx: click.Context, parameter: click.Parameter, file: Path | None) -> Path | None:
    if file is not None and file.suffix.lower() not in (".html", ".htm"):
        raise click.BadParameter(f"{str(file)!r} is no name of a page; allowed: a file that ends with .html")
    return file


@click.command(short_help="Tell results on one HTML page.")
@click.argument(
    "folders", metavar="DIR...", nargs=-1, required=True,
    type=click.Path(exists=True, file_okay=False, path_type=Path),
)  # fmt: skip
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    callback=_html_file,
    help="The HTML file; default DIR/report.html, of several folders report.html in the working folder.",
)
def report(folders: tuple[Path, ...], out: Path | None) -> None:
    """Tell the results in DIR... in one HTML file that needs nothing else, not even a network.

    DIR is the result of a run, of members of a case, or of a sweep; several are told side by side. A run that was
    stopped is told as far as it got.
    """
    from ngcell.report import write_report

    written = write_report(folders, out)
    for line in written.remarks:
        note(line)
    click.echo(f"{written.file}  ({written.file.stat().st_size / 1e6:.1f} MB)")
