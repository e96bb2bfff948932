"""NGSolve's own Newton method on the sheared 3x3 tissue, without continuation: where it ends.

    python -m tools.studies plain-newton

Mesh, law and supports are those of `shear-empty-3x3` on elements of order 2. `ngsolve.ContactBoundary` joins all walls
with all, with the normal that it keeps of the primary side (`normal`) or with the deformed normal of the secondary side
(`live`), and finds pairs anew after each iteration of `NewtonSolver`. The load grows in equal steps, each of which
starts with the lifting; or the whole load is there at once, from the walls as they were tied (`released`). A row tells
the load factor of the last step that converged, how the next one failed, and what it cost.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import isfinite
from time import process_time
from typing import Any

import click
import ngsolve as ngs
import numpy as np
from ngsolve.nonlinearsolvers import NewtonSolver

import ngcell
from ngcell.build.simulation import Simulation
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.studies.plain import mooney_rivlin

COLUMNS = ("start", "steps", "normal", "stiffness", "line search", "reached", "end", "iterations", "seconds")
#: Iterations of a step, and the norm of a converged one [energy ** 0.5].
MOST, TOLERANCE = 40, 1e-8


@dataclass(frozen=True)
class Setting:
    """How the tissue is solved: load steps, none if it is released, and contact."""

    steps: int
    normal: str
    multiple: float
    line_search: bool

    @property
    def start(self) -> str:
        """Where the walls come from."""
        return "pressed" if self.steps else "released"


def settings() -> Iterator[Setting]:
    """Yield all settings."""
    for steps, normal, multiple, search in product((0, 10, 40, 160), ("normal", "live"), (1.0, 10.0), (False, True)):
        yield Setting(steps, normal, multiple, search)


class Tissue:
    """The tissue with one contact boundary between all walls."""

    def __init__(self, setting: Setting) -> None:
        case: Any = ngcell.read_case("shear-empty-3x3", ["load.levels=1", "accuracy=inf", "mesh.order=2"])
        self.built = Simulation(case)
        space, bodies = self.built.space, self.built.bodies
        self.field = ngs.GridFunction(space.vector)
        self.form = ngs.BilinearForm(space.vector, symmetric=True)
        trial = space.vector.TrialFunction()
        law = case.material
        energy = mooney_rivlin(ngs.Id(2) + ngs.Grad(trial), law.c1, law.c2, law.bulk_modulus)
        self.form += ngs.Variation(energy.Compile() * ngs.dx)
        walls = space.mesh.Boundaries(bodies.wall_names)
        self.contact = ngs.ContactBoundary(walls, walls)
        gap = _gap(trial, self.contact, setting.normal)
        stiffness = setting.multiple * law.plane_strain_modulus / float(self.built.walls.depth.min())
        self.contact.AddEnergy(ngs.IfPos(gap, 0, stiffness / 4 * gap * gap))
        self.reach = float(bodies.thickness)

    def update(self, *_: Any) -> None:
        """Find pairs at the present displacement."""
        self.form.DeleteSpecialElements()
        self.contact.Update(self.field, self.form, intorder=5, maxdist=self.reach)

    @property
    def values(self) -> Any:
        """The unknowns."""
        return self.field.vec.FV().NumPy()


def _gap(trial: Any, contact: ngs.ContactBoundary, which: str) -> Any:
    """Return the gap by the normal that the boundary keeps, or by that of the deformed wall opposite; open > 0."""
    offset = trial - trial.Other() + ngs.CF((ngs.x, ngs.y)) - ngs.CF((ngs.x, ngs.y)).Other()
    if which == "normal":
        return -(offset * contact.normal)
    normal = ngs.specialcf.normal(2)
    along = ngs.CF((-normal[1], normal[0]))
    tangent = along.Other() + ngs.Grad(trial).Trace().Other() * along.Other()
    return offset * ngs.CF((tangent[1], -tangent[0])) / ngs.Norm(tangent)


def solved(setting: Setting) -> dict[str, Any]:
    """Return how far the load gets."""
    tissue = Tissue(setting)
    motion, free = tissue.built.motion, ngs.BitArray(len(tissue.values))
    for unknown, is_fixed in enumerate(motion.fixed.ravel()):
        free[unknown] = not is_fixed
    if not setting.steps:
        tissue.values[:] = next(tissue.built.accepted_steps()).displacement
    reached, before, count, end, started = 0.0, 0.0, 0, "done", process_time()
    for load in np.arange(1, setting.steps + 1) / setting.steps if setting.steps else (1.0,):
        if setting.steps:
            tissue.values[:] += motion.lifting(float(load)) - motion.lifting(before)
        tissue.update()
        solver = NewtonSolver(tissue.form, tissue.field, freedofs=free, inverse="umfpack")
        try:
            failed, needed = solver.Solve(MOST, TOLERANCE, callback=tissue.update, linesearch=setting.line_search)
        except Exception as error:  # what NGSolve raises differs by solver
            end = f"error: {str(error).splitlines()[0][:40]}"
            break
        count += needed
        energy = tissue.form.Energy(tissue.field.vec)
        if failed or not isfinite(energy):
            end = "no convergence" if isfinite(energy) else "not a number"
            break
        reached, before = float(load), float(load)
    row = (setting.start, setting.steps, setting.normal, setting.multiple, setting.line_search, reached, end, count)
    return dict(zip(COLUMNS, (*row, round(process_time() - started, 1)), strict=True))


@described(__doc__)
def command() -> None:
    """Solve all settings and write the tables."""
    ngs.SetNumThreads(1)
    rows = []
    for setting in settings():
        rows.append(solved(setting))
        click.echo(", ".join(map(str, rows[-1].values())), err=True)
    tables.write(RESULTS / "plain-newton.csv", COLUMNS, rows)
    text = f"# NGSolve's own Newton method\n\n{(__doc__ or '').splitlines()[0]}\n\n"
    text += tables.markdown(COLUMNS, ([row[name] for name in COLUMNS] for row in rows))
    (RESULTS / "plain-newton.md").write_text(text + "\n", encoding="utf-8")
