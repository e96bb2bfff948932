"""One run of the map, as `ngcell solve` would make it, and what the last tangent is like.

    python -m tools.extreme one CASE FOLDER [--tolerance 1.0]

The result folder is that of any run, without pictures. The last line of output is a number: an estimate of the
condition of the last tangent, proximal term and closed penalty terms included, in the 2-norm. `--tolerance` multiplies
the decrement at which equilibria end.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path

import click

import ngcell
from ngcell.errors import NgcellError, NotConverged
from ngcell.export import read_restart
from ngcell.export.restart import RESTART
from tools.commands import described
from tools.extreme.condition import condition
from tools.studies.numbers import with_tolerance


@described(__doc__)
@click.argument("case", type=click.Path(path_type=Path))
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--tolerance", default=1.0, help="Multiple of the decrement at which equilibria end.")
def command(case: Path, folder: Path, tolerance: float) -> None:
    """Run CASE into FOLDER."""
    last, scene = None, ngcell.read_case(case)
    try:
        options = with_tolerance(tolerance)
        recording = ngcell.record(scene, folder, options=options, threads=1, force=True, pictures=False)
        for _ in recording:
            last = read_restart(folder).checkpoint if (folder / RESTART).exists() else last
        code = 0 if recording.certified else NotConverged.exit_code
    except NgcellError as error:
        click.echo(str(error), err=True)
        code = error.exit_code
    found = float("nan")
    if last is not None and "displacement_released" in last:
        with suppress(RuntimeError):
            found = condition(scene, last["displacement_released"])
    click.echo(f"{found:.3g}")
    sys.exit(code)
