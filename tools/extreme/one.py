"""One run of the map, as `ngcell solve` would make it, and what the last tangent is like.

    python -m tools.extreme one CASE FOLDER [--tolerance 1.0]

The result folder is that of any run, without pictures. The last line of output is a number: an estimate of the
condition of the last tangent, proximal term and closed penalty terms included, in the 2-norm. `--tolerance` multiplies
the decrement at which equilibria end.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from unittest.mock import patch

import click

import ngcell
from ngcell import recording as recordings
from ngcell.build.options import Options
from ngcell.build.simulation import Simulation
from ngcell.errors import NgcellError, NotConverged
from ngcell.export import ResultFolder, read_restart
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
    with _recorded(with_tolerance(tolerance)):
        try:
            recording = ngcell.record(scene, folder, threads=1, force=True)
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


@contextmanager
def _recorded(options: Options) -> Iterator[None]:
    """Let runs into result folders take these options, and leave out their pictures, which take longer than the runs.

    `ngcell.record` takes neither; that the options arrive is tested.
    """
    simulation = partial(Simulation, options=options)
    with patch.object(recordings, "Simulation", simulation), patch.object(ResultFolder, "draw"):
        yield
