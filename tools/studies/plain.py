"""Problems as NGSolve's tutorials have them, with nothing of this package but the mesh: what studies compare with."""

from __future__ import annotations

from math import inf
from time import process_time
from typing import Any

import ngsolve as ngs
from netgen import occ

import ngcell
from ngcell import Body, BodyScene, BodySupport

#: The clamped block: constants c1 and c2, bulk modulus, and by how much its top is pressed down.
C1, C2, BULK, DOWN = 0.5, 0.5, 50.0, 0.03


def mooney_rivlin(gradient: Any, c1: float, c2: float, bulk_modulus: float) -> Any:
    """Return ``c1/2 (I1* - 3) + c2/2 (I2* - 3) + kappa/2 (ln J)^2`` in plane strain [stress]."""
    jacobian, square = ngs.Det(gradient), ngs.InnerProduct(gradient, gradient)
    log_jacobian = ngs.log(jacobian)
    scale = ngs.exp(-2 / 3 * log_jacobian)
    first, second = scale * (square + 1), scale * scale * (square + jacobian * jacobian)
    return c1 / 2 * (first - 3) + c2 / 2 * (second - 3) + bulk_modulus / 2 * log_jacobian * log_jacobian


def block(size: float, order: int) -> BodyScene:
    """Return the clamped block, pressed down."""
    face = occ.Rectangle(1, 1).Face()
    for direction, name in ((occ.Y, "top"), (-occ.Y, "bottom")):
        face.edges.Max(direction).name = name
    face.maxh = size
    material = ngcell.MooneyRivlin(c1=C1, c2=C2, bulk_modulus=BULK)
    supports = [BodySupport("bottom"), BodySupport("top", translation=(0.0, -DOWN))]
    return BodyScene([Body(face, material, "block", ())], supports, size=size, order=order, levels=1, accuracy=inf)


def newton(scene: BodyScene) -> dict[str, float]:
    """Solve the block by Newton's method in one step."""
    mesh = ngs.Mesh(occ.OCCGeometry(scene.bodies[0].shape, dim=2).GenerateMesh(maxh=scene.size))
    space = ngs.VectorH1(mesh, order=scene.order, dirichlet="bottom|top")
    form = ngs.BilinearForm(space, symmetric=True)
    gradient = ngs.Id(2) + ngs.Grad(space.TrialFunction())
    form += ngs.Variation(mooney_rivlin(gradient, C1, C2, BULK).Compile() * ngs.dx)
    field = ngs.GridFunction(space)
    field.Set(ngs.CF((0, -DOWN * ngs.y)))
    residual, change = field.vec.CreateVector(), field.vec.CreateVector()
    inverse, iterations = None, 0
    while True:
        form.Apply(field.vec, residual)
        form.AssembleLinearization(field.vec)
        inverse = inverse or form.mat.Inverse(space.FreeDofs(), "sparsecholesky")
        inverse.Update()
        change.data = inverse * residual
        iterations += 1
        field.vec.data -= change
        if abs(ngs.InnerProduct(change, residual)) < 1e-16 or iterations == 30:
            break
    return {"unknowns": space.ndof, "iterations": iterations, "energy": form.Energy(field.vec)}


def one_body(size: float = 0.04, order: int = 3) -> dict[str, float]:
    """Return processor seconds of the clamped block here and in plain NGSolve."""
    ngs.SetNumThreads(1)
    ngcell.simulate(block(0.5, order))  # imports what is imported when it is first needed
    scene, times = block(size, order), [process_time()]
    *_, step = ngcell.simulate(scene)
    times.append(process_time())
    plain = newton(scene)
    times.append(process_time())
    ours, theirs = times[1] - times[0], times[2] - times[1]
    return {
        "unknowns": float(plain["unknowns"]),
        "seconds": ours,
        "iterations": float(step.record.iterations),
        "factorisations": float(step.record.factorisations),
        "seconds of plain NGSolve": theirs,
        "iterations of plain NGSolve": float(plain["iterations"]),
        "ratio": ours / theirs,
        "energies apart": abs(step.record.energy / plain["energy"] - 1),
    }
