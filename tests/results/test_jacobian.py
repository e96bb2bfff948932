"""The smallest J of whole elements against dense samples, and against deformations in closed form."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.bernstein import FACTORS, Bernstein
from ngcell.results.jacobian import smallest_jacobian
from ngcell.results.places import element_type, map_points

ORDERS = (1, 2, 3, 4)


def rings(order: int = 1) -> BodyMesh:
    lattice = hexagonal_lattice(1, 2, side=1.0, pointy=True)
    return ring_mesh(lattice.outlines, wall=0.2, radius=0.1, edges=2, layers=1, supports={})


def disc(order: int) -> BodyMesh:
    return mesh_shapes([occ.Circle((0, 0), 1).Face()], ["disc"], order=order, size=0.8)


def ball(order: int) -> BodyMesh:
    return mesh_shapes([occ.Sphere((0, 0, 0), 1)], ["ball"], order=order, size=1.5)


def box(kind: ngsolve.ET) -> BodyMesh:
    from ngsolve.meshes import MakeStructured3DMesh

    mesh = MakeStructured3DMesh(hexes=kind is ngsolve.ET.HEX, prism=kind is ngsolve.ET.PRISM, nx=2, ny=1, nz=1)
    return BodyMesh(mesh, np.zeros(mesh.ne, dtype=np.int64), ("box",), ".*", 1.0, 1.0)


SPACES = {
    **{f"quads-{order}": (lambda order=order: DisplacementSpace(rings(), order)) for order in ORDERS},
    **{f"disc-{order}": (lambda order=order: DisplacementSpace(disc(order), order)) for order in ORDERS},
    "tets-2": lambda: DisplacementSpace(ball(2), 2),
    "hexes-2": lambda: DisplacementSpace(box(ngsolve.ET.HEX), 2),
    "prisms-2": lambda: DisplacementSpace(box(ngsolve.ET.PRISM), 2),
}


@pytest.fixture(params=SPACES)
def space(request) -> DisplacementSpace:
    return SPACES[request.param]()


def sampled(space: DisplacementSpace, displacement: np.ndarray, count: int = 21) -> float:
    """The smallest J on a lattice in each element."""
    kind = element_type(space)
    axis = np.linspace(0, 1, count if space.dimension == 2 else 9)
    points = np.stack(np.meshgrid(*[axis] * space.dimension), axis=-1).reshape(-1, space.dimension)
    if FACTORS[kind][0] > 1:
        points = points[points[:, : FACTORS[kind][0]].sum(1) <= 1 + 1e-12]
    places = map_points(space, kind, points)
    gradient = ngsolve.Grad(space.function(displacement))(places).reshape(-1, space.dimension, space.dimension)
    return float(np.linalg.det(gradient + np.eye(space.dimension)).min())


def random_displacement(space: DisplacementSpace, size: float) -> np.ndarray:
    return size * np.random.default_rng(5).normal(size=space.unknowns)


def test_a_uniform_deformation_has_its_jacobian(space):
    gradient = np.eye(space.dimension) + 0.2 * np.arange(space.dimension**2).reshape(space.dimension, -1) / 9
    displacement = space.affine(gradient - np.eye(space.dimension), np.ones(space.dimension)).ravel()
    assert smallest_jacobian(space, displacement).value == pytest.approx(np.linalg.det(gradient), rel=1e-8)


@pytest.mark.parametrize("size", [1e-3, 1e-2, 0.05])
def test_the_bound_is_below_all_samples_and_near_the_smallest(space, size):
    displacement = random_displacement(space, size)
    found, least = smallest_jacobian(space, displacement).value, sampled(space, displacement)
    assert found <= least + 1e-9
    assert found > least - 0.02 * max(abs(least), 0.1) - 0.1 * abs(1 - least)


def test_a_mirrored_body_is_inside_out(space):
    gradient = np.diag([-1.0, *[1.0] * (space.dimension - 1)])
    displacement = space.affine(gradient - np.eye(space.dimension), np.zeros(space.dimension)).ravel()
    assert smallest_jacobian(space, displacement).value == pytest.approx(-1)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_an_element_that_folds_between_the_points_of_the_energy_is_seen(order):
    """Just before the energy stops to exist, J > 0 at all of its points, and J < 0 in between."""
    space = DisplacementSpace(rings(), order)
    energy = BodyEnergy(space, [MooneyRivlin(c1=1.0, c2=0.5, bulk_modulus=10.0)] * 2).form.energy
    direction = random_displacement(space, 1.0)
    exists, fails = 0.0, 10.0
    for _ in range(40):
        middle = (exists + fails) / 2
        exists, fails = (exists, middle) if np.isnan(energy(middle * direction)) else (middle, fails)
    assert np.isfinite(energy(exists * direction))
    assert smallest_jacobian(space, exists * direction).value < 0


def test_it_is_told_where():
    space = DisplacementSpace(rings(), 2)
    field = ngsolve.GridFunction(space.vector)
    field.Set(ngsolve.CF((-0.05 * ngsolve.x * ngsolve.x, 0)))
    found = smallest_jacobian(space, field.vec.FV().NumPy().copy())
    right = space.bodies.extent[1, 0]
    assert found.value == pytest.approx(1 - 0.1 * right, rel=0.01)
    assert found.point[0] > right - 0.3
    assert space.bodies.body_of_element[found.element] == 1


@pytest.mark.parametrize("kind", FACTORS)
def test_pieces_of_an_element_have_the_polynomial_of_the_whole(kind):
    basis = Bernstein(kind, (2,) * len(FACTORS[kind]))
    coefficients = np.random.default_rng(1).normal(size=len(basis.lattice))
    for number, piece in enumerate(basis.pieces):
        centre = basis.centre_of([number])
        middle = basis.centre_of([])
        there = basis.values(centre[None]) @ coefficients
        assert basis.values(middle[None]) @ (piece @ coefficients) == pytest.approx(there)
