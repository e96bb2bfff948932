"""NGSolve as its tutorial on contact has it, on the rings.

`ContactBoundary` with a penalty on one side, the loads in steps, and Newton's method with halved steps.
"""

from __future__ import annotations

from time import process_time
from typing import Any

import ngsolve as ngs
import numpy as np

from tools.studies.plain import mooney_rivlin
from tools.studies.work_precision import rings
from tools.studies.work_precision.grid import Setting
from tools.studies.work_precision.rings_elsewhere import mesh_and_stiffness, row

#: Load steps, iterations of each, and halvings of a Newton step.
STEPS, ITERATIONS, HALVINGS = 40, 60, 12


def naive(setting: Setting) -> dict[str, Any]:
    """Solve with NGSolve's contact boundary."""
    ngs.SetNumThreads(1)
    started = process_time()
    mesh, stiffness = mesh_and_stiffness(setting)
    space = ngs.VectorH1(mesh, order=setting.order, dirichletx="inner-y|outer-y", dirichlety="inner-x|outer-x")
    trial, test = space.TnT()
    gradient = ngs.Id(2) + ngs.Grad(trial)
    share = ngs.Parameter(0.0)
    form = ngs.BilinearForm(space)
    energy = mooney_rivlin(gradient, rings.C1, rings.C2, rings.split(setting.problem)[1])
    form += ngs.Variation(energy.Compile() * ngs.dx)
    pressure = rings.PROBLEMS[setting.problem][3]
    if pressure is not None:
        along, normal = ngs.Grad(trial).Trace(), ngs.specialcf.normal(2)
        turned = ngs.CF(
            (
                normal[0] + along[1, 1] * normal[0] - along[1, 0] * normal[1],
                normal[1] + along[0, 0] * normal[1] - along[0, 1] * normal[0],
            )
        )
        form += share * pressure * (turned * test) * ngs.ds("inner-bore")
    contact = ngs.ContactBoundary(mesh.Boundaries("inner-rim"), mesh.Boundaries("outer-bore"))
    place = ngs.CF((ngs.x, ngs.y))
    overlap = (place + trial - place.Other() - trial.Other()) * contact.normal
    contact.AddEnergy(ngs.IfPos(overlap, stiffness / 2 * overlap * overlap, 0))
    field, iterations = ngs.GridFunction(space), 0
    residual, step, old = (field.vec.CreateVector() for _ in range(3))
    free = np.array(list(space.FreeDofs()))

    def missed() -> float:
        form.Apply(field.vec, residual)
        return float(np.linalg.norm(residual.FV().NumPy()[free]))

    steps = STEPS if pressure is not None else 1
    for number in range(steps):
        share.Set((number + 1) / steps)
        for _ in range(ITERATIONS):
            contact.Update(field, form, intorder=2 * setting.order, maxdist=0.3)
            before = missed()
            if before < 1e-10:
                break
            form.AssembleLinearization(field.vec)
            step.data = form.mat.Inverse(space.FreeDofs(), inverse="umfpack") * residual
            iterations += 1
            old.data, length = field.vec, 1.0
            for _ in range(HALVINGS):
                field.vec.data = old - length * step
                if missed() < before:
                    break
                length /= 2
        else:
            raise SystemExit(f"no convergence in step {number + 1} of {steps}; residual {before:.0e}")
    form.Apply(field.vec, residual)
    seconds = process_time() - started
    forces, moved = residual.FV().NumPy(), field.vec.FV().NumPy()
    count = space.ndof // 2
    mine = {name: np.array(list(space.components[0].GetDofs(mesh.Boundaries(name)))) for name in _names()}
    at = [
        np.array([mesh[ngs.NodeId(ngs.VERTEX, n)].point for n in np.flatnonzero(mine[name][: mesh.nv])])
        + np.column_stack([moved[:count][: mesh.nv], moved[count:][: mesh.nv]])[mine[name][: mesh.nv]]
        for name in rings.BOUNDARIES
    ]
    vertices = np.arange(count) < mesh.nv
    hoop = -(forces[count:][mine["outer-x"] & vertices].sum() + forces[:count][mine["outer-y"] & vertices].sum()) / 2
    return row(setting, at, hoop, space.ndof, iterations, seconds)


def _names() -> tuple[str, ...]:
    return (*rings.BOUNDARIES, "outer-x", "outer-y")
