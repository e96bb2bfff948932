"""Build the site into a folder, by default build/site: python -m tools.docs site

Pages are copied from docs, with the documents at the top of the repository and the tables of results that they link.
Further ones are made: the case reference from the JSON schema, the commands from click, the Python reference from the
public names, the gallery by running its scripts, and the notebooks from their files. A warning is an error.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import click

from tools.commands import described
from tools.docs import gallery, notebooks, reference
from tools.docs.case_reference import case_reference
from tools.docs.extra import check_extra
from tools.docs.sources import copy_pages
from tools.places import ROOT

WORK = ROOT / "build" / "docs"


def prepare(source: Path, *, pictures: Path, run_gallery: bool = True) -> None:
    """Write all pages of the site into an empty folder, as Sphinx reads them.

    Parameters
    ----------
    source : Path
        The folder; what it holds is removed.
    pictures : Path
        Where results of the gallery are kept between builds.
    run_gallery : bool
        Whether scripts of the gallery are run, or shown without results.
    """
    shutil.rmtree(source, ignore_errors=True)
    copy_pages(source)
    (source / "reference").mkdir()
    (source / "reference" / "case.md").write_text(case_reference())
    (source / "reference" / "commands.rst").write_text(reference.commands())
    (source / "reference" / "python.rst").write_text(reference.names())
    notebooks.write_pages(source / "notebooks")
    gallery.write_pages(source / "gallery", pictures if run_gallery else None)


def sphinx(source: Path, out: Path, doctrees: Path) -> int:
    """Run Sphinx over prepared pages, with warnings as errors, and return its exit code."""
    from sphinx.cmd.build import main

    told = ["-b", "html", "-n", "-W", "--keep-going", "-q", "-d", str(doctrees)]
    return main([*told, str(source), str(out)])


@described(__doc__)
@click.option("--out", type=click.Path(path_type=Path), default=ROOT / "build" / "site", help="Folder of the site.")
@click.option("--no-gallery", is_flag=True, help="Show the scripts of the gallery without running them.")
def command(out: Path, no_gallery: bool) -> None:
    check_extra("docs", "sphinx", "myst_parser", "furo", "sphinx_click", "sphinx_copybutton", "nbformat")
    source = WORK / "source"
    prepare(source, pictures=WORK / "gallery", run_gallery=not no_gallery)
    code = sphinx(source, out, WORK / "doctrees")
    if code == 0:
        click.echo(f"{out / 'index.html'}")
    raise SystemExit(code)
