"""One run of `tools.extreme`, as `ngcell solve` would make it, and what the last tangent is like.

    python -m tools.extreme_run CASE FOLDER [--tolerance 1.0]

The result folder is that of any run, without pictures. The last line of output is a number: an estimate of the
condition of the last tangent, proximal term and closed penalty terms included, in the 2-norm. `--tolerance` multiplies the decrement
at which equilibria end.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.errors import NgcellError, NotConverged
from ngcell.export import ResultFolder, read_restart
from ngcell.export.restart import RESTART
from ngcell.scene import AnyCase
from ngcell.solve import continuation
from ngcell.solve.minimise import TOUCHING

Array = NDArray[np.float64]

_POWERS = 40


def condition(case: AnyCase, displacement: Array) -> float:
    """Return an estimate of the condition of the released tangent about a displacement."""
    simulation = Simulation(case)
    assembly, path = simulation.released, simulation.continuation
    for load in filter(None, (simulation.discretisation.loads, simulation.discretisation.fluid)):
        load.apply(simulation.levels[-1])
    line = assembly.linearise(assembly.at(displacement))
    rows, columns = assembly.pattern
    lower = sparse.coo_array((line.stiffness, (rows, columns)), shape=assembly.mass.shape).tocsr()
    matrix = lower + lower.T - sparse.diags_array(lower.diagonal())
    if line.curvature is not None:
        matrix = matrix + line.curvature
    closed = np.where(line.gap <= TOUCHING * simulation.longest_step, line.penalty, 0.0)
    matrix = matrix + line.jacobian.T @ (sparse.diags_array(closed) @ line.jacobian)
    matrix = matrix + path.scale * path.last * assembly.mass
    free = np.flatnonzero(assembly.free)
    matrix = matrix.tocsc()[free][:, free]
    return _largest(matrix.dot, len(free)) * _largest(splu(matrix).solve, len(free))


def _largest(apply: Callable[[Array], Array], size: int) -> float:
    """Return the largest magnitude of an eigenvalue of a symmetric operator, by so many steps of the power method."""
    vector, length = np.random.default_rng(0).standard_normal(size), 1.0
    for _ in range(_POWERS):
        vector = apply(vector / np.linalg.norm(vector))
        length = float(np.linalg.norm(vector))
    return length


@click.command()
@click.argument("case", type=click.Path(path_type=Path))
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--tolerance", default=1.0, help="Multiple of the decrement at which equilibria end.")
def main(case: Path, folder: Path, tolerance: float) -> None:
    """Run CASE into FOLDER."""
    continuation.AT_THE_END *= tolerance
    ResultFolder.draw = lambda *_, **__: None  # pictures take longer than many of these runs
    last, code, scene = None, 0, ngcell.read_case(case)
    try:
        recording = ngcell.record(scene, folder, threads=1)
        for _ in recording:
            last = read_restart(folder).checkpoint if (folder / RESTART).exists() else last
        code = 0 if recording.certified else NotConverged.exit_code
    except NgcellError as error:
        click.echo(str(error), err=True)
        code = error.exit_code
    found = np.nan
    if last is not None and "displacement_contact" in last:
        with suppress(RuntimeError):
            found = condition(scene, last["displacement_contact"])
    click.echo(f"{found:.3g}")
    sys.exit(code)


if __name__ == "__main__":
    main()
