"""What an order leaves of an error at a corner, beside Poisson's equation on an L of three squares."""

from __future__ import annotations

from functools import cache

import ngsolve
import pytest
from netgen.meshing import Element1D, Element2D, FaceDescriptor, Mesh, MeshPoint, Pnt

import ngcell
from ngcell.build.stages import Stage

#: Sides of elements, as shares of those of a square, from the corner: graded so far that nothing is left there.
GRADED = tuple(0.1**step for step in range(8, -1, -1))


def l_mesh(sides: tuple[float, ...]) -> ngsolve.Mesh:
    """Squares around (0, 0) without the lower right one."""
    lines, corner, mesh = (*(-side for side in sides[::-1]), 0.0, *sides), len(sides), Mesh(dim=2)
    count = range(len(lines) - 1)
    squares = [(i, j) for i in count for j in count if not (i >= corner > j)]
    around = [[(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)] for i, j in squares]
    places = sorted({place for square in around for place in square})
    point = {(i, j): mesh.Add(MeshPoint(Pnt(lines[i], lines[j], 0))) for i, j in places}
    mesh.Add(FaceDescriptor(surfnr=1, domin=1, bc=1))
    edges = {(one, two) for square in around for one, two in zip(square, square[1:] + square[:1], strict=True)}
    for square in around:
        mesh.Add(Element2D(1, [point[place] for place in square]))
    for one, two in sorted(edges):
        if (two, one) not in edges:
            mesh.Add(Element1D([point[one], point[two]], index=1))
    mesh.SetBCName(0, "rim")
    return ngsolve.Mesh(mesh)


@cache
def energy(order: int, sides: tuple[float, ...] = (1.0,)) -> float:
    space = ngsolve.H1(l_mesh(sides), order=order, dirichlet="rim")
    u, v = space.TnT()
    stiffness = ngsolve.BilinearForm(ngsolve.grad(u) * ngsolve.grad(v) * ngsolve.dx).Assemble()
    load = ngsolve.LinearForm(v * ngsolve.dx).Assemble()
    solution = stiffness.mat.Inverse(space.FreeDofs()) * load.vec
    return float(ngsolve.InnerProduct(solution, load.vec))


@pytest.mark.parametrize("order", [4, 5, 6, 7])
def test_an_order_leaves_the_share_that_is_told(order: int):
    """Its exponent is 2/3; the power of the order itself is further off."""
    before, after = (energy(10, GRADED) - energy(one) for one in (order, order + 1))
    scene = ngcell.read_case("shear-empty-3x3")
    told = Stage(scene, order + 1, 0).refining(Stage(scene, order, 0), 2 / 3)
    assert after / before == pytest.approx(told.remains, rel=0.03)
    assert abs(told.remains_of_gaps - after / before) > abs(told.remains - after / before) or order == 4
