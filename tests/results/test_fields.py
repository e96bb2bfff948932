"""Fields of a snapshot against deformations that are known in closed form."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest
from netgen import meshing, occ

from ngcell.contact.surface.find import find_surface
from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.problem import Problem
from ngcell.problem.tie import tie_walls
from ngcell.results.fields import take_fields
from ngcell.results.places import element_type
from ngcell.results.snapshot import Snapshot

ORDERS = (1, 2, 3, 4)
SOFT, STIFF = MooneyRivlin(c1=1.0, c2=0.5, bulk_modulus=10.0), MooneyRivlin(c1=3.0, c2=2.0, bulk_modulus=50.0)
STRETCHED = np.array([[1.3, 0.2], [-0.1, 0.9]])
CORNERS = {28: 4, 22: 3}


def rings(pointy: bool = True, cells: int = 3, radius: float = 0.0) -> BodyMesh:
    lattice = hexagonal_lattice(1, cells, side=1.0, pointy=pointy)
    return ring_mesh(lattice.outlines, wall=0.2, radius=radius, edges=2, layers=2, supports={})


def discs(curved: int) -> BodyMesh:
    """Two discs of radius 1, apart, meshed with curved triangles; all of their boundary is wall."""
    faces = [occ.Circle((x, 0), 1).Face() for x in (0.0, 3.0)]
    for number, face in enumerate(faces):
        face.faces.name = f"disc{number}"
        face.edges.name = "wall"
    shape = occ.OCCGeometry(occ.Compound(faces), dim=2)
    mesh = ngsolve.Mesh(shape.GenerateMesh(maxh=0.8)).Curve(curved)
    body = np.array([element.mat == "disc1" for element in mesh.Elements(ngsolve.VOL)], dtype=np.int64)
    return BodyMesh(mesh, body, ("disc0", "disc1"), "wall", 1.0, 1.0)


BODIES = {
    "pointy": lambda order: rings(),
    "flat": lambda order: rings(pointy=False),
    "round": lambda order: rings(radius=0.3),
    "discs": discs,
}


@pytest.fixture(params=[(kind, order) for kind in BODIES for order in ORDERS], ids=lambda p: f"{p[0]}-{p[1]}")
def problem(request) -> Problem:
    kind, order = request.param
    return problem_of(BODIES[kind](order), order)


def problem_of(bodies: BodyMesh, order: int) -> Problem:
    space = DisplacementSpace(bodies, order)
    laws = [SOFT, STIFF, SOFT][: bodies.body_count]
    return Problem(space, [BodyEnergy(space, laws)], np.zeros((2, space.size), dtype=bool))


def snapshot(problem: Problem, displacement: np.ndarray, **data: dict[str, np.ndarray]) -> Snapshot:
    walls = find_surface(problem.space.bodies, problem.space.scalar, problem.space.rest)
    at, given = problem.configuration(displacement.ravel()), {"wall_data": {}, "body_data": {}} | data
    return Snapshot(4, 0.5, 0.2, *take_fields(problem, at, walls=walls, **given))


def interpolated(problem: Problem, field: ngsolve.CoefficientFunction) -> np.ndarray:
    function = ngsolve.GridFunction(problem.space.vector)
    function.Set(field)
    return function.vec.FV().NumPy().copy()


def stored_energy(law: MooneyRivlin, gradient: np.ndarray) -> complex:
    """W of a full 3 x 3 deformation gradient, from the invariants of C; takes complex entries."""
    right = gradient.T @ gradient
    jacobian = np.linalg.det(gradient)
    first = np.trace(right)
    second = (first**2 - np.trace(right @ right)) / 2
    isochoric = law.c1 * (first * jacobian ** (-2 / 3) - 3) + law.c2 * (second * jacobian ** (-4 / 3) - 3)
    return (isochoric + law.bulk_modulus * np.log(jacobian) ** 2) / 2


def differentiated_stress(law: MooneyRivlin, gradient: np.ndarray) -> np.ndarray:
    """``sigma = dW/dF F^T / J``, with dW/dF by complex steps, which lose no digits."""
    first_piola = np.zeros((3, 3))
    for entry in np.ndindex(3, 3):
        step = np.zeros((3, 3), dtype=complex)
        step[entry] = 1e-30j
        first_piola[entry] = stored_energy(law, gradient + step).imag / 1e-30
    return first_piola @ gradient.T / np.linalg.det(gradient)


def plane_strain(gradient: np.ndarray) -> np.ndarray:
    full = np.eye(3)
    full[:2, :2] = gradient
    return full


def is_straight(problem: Problem) -> bool:
    bodies = problem.space.bodies
    return bodies.rounded is None and bodies.mesh.GetCurveOrder() <= 1


def cell_areas(points: np.ndarray, cells: np.ndarray, cell_type: int) -> np.ndarray:
    x, y = points[cells[:, : CORNERS[cell_type]], :2].transpose(2, 0, 1)
    return (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(1) / 2


def test_a_uniform_deformation_has_its_jacobian_and_stress_everywhere(problem):
    affine = problem.space.affine(STRETCHED - np.eye(2), np.array([0.3, -0.2]))
    bulk = snapshot(problem, affine).bulk
    gradient = plane_strain(STRETCHED)
    assert bulk.point_data["J"] == pytest.approx(np.linalg.det(STRETCHED), rel=1e-9)
    for body, law in enumerate(problem.terms[0].laws):
        mine = np.unique(bulk.cells[bulk.cell_data["cell_id"] == body])
        stress = differentiated_stress(law, gradient)
        deviator = stress - np.trace(stress) / 3 * np.eye(3)
        expected = np.tile(stress.ravel(), (len(mine), 1))
        np.testing.assert_allclose(bulk.point_data["cauchy_stress"][mine], expected, atol=1e-8)
        np.testing.assert_allclose(
            bulk.point_data["von_mises"][mine], np.sqrt(1.5) * np.linalg.norm(deviator), rtol=1e-8
        )


def test_an_affine_displacement_is_exact_at_the_points(problem):
    translation = np.array([0.3, -0.2])
    taken = snapshot(problem, problem.space.affine(STRETCHED - np.eye(2), translation))
    for grid in (taken.bulk, taken.walls):
        expected = grid.points[:, :2] @ (STRETCHED - np.eye(2)).T + translation
        np.testing.assert_allclose(grid.point_data["displacement"][:, :2], expected, atol=1e-11)
        assert not grid.points[:, 2].any()
        assert not grid.point_data["displacement"][:, 2].any()


def test_cells_cover_each_body_once_and_anticlockwise(problem):
    bulk = snapshot(problem, np.zeros(problem.space.unknowns)).bulk
    areas = cell_areas(bulk.points, bulk.cells, bulk.cell_type)
    assert areas.min() > 0
    assert len(np.unique(bulk.cells)) == len(bulk.points)
    area = ngsolve.Integrate(ngsolve.CF(1), problem.space.mesh)
    assert areas.sum() == pytest.approx(area, rel=1e-12 if is_straight(problem) else 0.1)  # arcs are cut off


def test_middles_and_centres_stand_where_vtk_expects_them(problem):
    bulk = snapshot(problem, np.zeros(problem.space.unknowns)).bulk
    count = CORNERS[bulk.cell_type]
    corner = bulk.points[bulk.cells[:, :count]]
    middle = (corner + np.roll(corner, -1, axis=1)) / 2
    sagitta = 1e-14 if is_straight(problem) else 0.1
    np.testing.assert_allclose(bulk.points[bulk.cells[:, count : 2 * count]], middle, atol=sagitta)
    for centre in bulk.points[bulk.cells[:, 2 * count :]].transpose(1, 0, 2):
        np.testing.assert_allclose(centre, corner.mean(1), atol=1e-14 if is_straight(problem) else 0.01)


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("pointy", [True, False])
def test_a_quadratic_displacement_is_exact_at_the_points(order, pointy):
    problem = problem_of(rings(pointy), order)
    x, y = ngsolve.x, ngsolve.y
    taken = snapshot(problem, interpolated(problem, ngsolve.CF((0.1 * x * y + 0.05 * y * y, 0.02 * x * x))))
    for grid in (taken.bulk, taken.walls):
        x, y, _ = grid.points.T
        expected = np.column_stack([0.1 * x * y + 0.05 * y**2, 0.02 * x**2, 0 * x])
        np.testing.assert_allclose(grid.point_data["displacement"], expected, atol=1e-11)
    x, y, _ = taken.bulk.points.T
    jacobian = 1 + 0.1 * y - (0.1 * x + 0.1 * y) * 0.04 * x
    np.testing.assert_allclose(taken.bulk.point_data["J"], jacobian, atol=1e-9)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_points_lie_on_curved_boundaries(order):
    taken = snapshot(problem_of(discs(order), order), np.zeros(problem_of(discs(order), order).space.unknowns))
    centre = 3.0 * np.repeat(taken.walls.cell_data["cell_id"], 3)
    x, y, _ = taken.walls.points.T
    np.testing.assert_allclose(np.hypot(x - centre, y), 1, atol=2e-3)
    x, y, _ = taken.bulk.points.T
    farthest = np.hypot(x - 3.0 * (x > 1.5), y).max()
    assert farthest == pytest.approx(1, abs=2e-3)


def test_cells_know_their_body_and_what_is_told_of_it():
    problem = problem_of(rings(), 2)
    data = {"free": np.array([0, 1, 0]), "cell_pressure": np.array([0.3, 0.1, 0.2])}
    bulk = snapshot(problem, np.zeros(problem.space.unknowns), body_data=data).bulk
    centre = bulk.points[bulk.cells].mean(1)[:, 0]
    body = np.round(centre / np.sqrt(3)).astype(int)
    assert np.array_equal(bulk.cell_data["cell_id"], body)
    assert np.array_equal(bulk.cell_data["free"], body == 1)
    assert np.array_equal(bulk.cell_data["cell_pressure"], data["cell_pressure"][body])


def test_walls_carry_gap_and_pressure_at_their_ends_and_middle():
    problem = problem_of(rings(), 2)
    space = problem.space
    walls = find_surface(space.bodies, space.scalar, space.rest)
    at = walls.basis.values(np.array([0.0, 0.5, 1.0])) @ walls.rest
    data = {"gap": at[..., 0], "contact_pressure": at[..., 1]}
    grid = snapshot(problem, np.zeros(space.unknowns), wall_data=data).walls
    assert grid.cell_type == 21
    np.testing.assert_allclose(grid.point_data["gap"], grid.points[:, 0], atol=1e-14)
    np.testing.assert_allclose(grid.point_data["contact_pressure"], grid.points[:, 1], atol=1e-14)
    ends_and_middle = grid.points[grid.cells]
    np.testing.assert_allclose(ends_and_middle[:, 2], ends_and_middle[:, :2].mean(1), atol=1e-12)
    assert np.array_equal(grid.cell_data["cell_id"], walls.body)


def test_slaves_follow_their_masters():
    bodies = rings()
    space = DisplacementSpace(bodies, 2)
    tie = tie_walls(find_surface(bodies, space.scalar, space.rest), space.size)
    tied = Problem(space, [BodyEnergy(space, [SOFT] * 3)], np.zeros((2, space.size), dtype=bool), tie=tie)
    affine = space.affine(STRETCHED - np.eye(2), np.zeros(2)).ravel()
    masters_only = np.where(tied.free, affine, 0)
    jacobian = snapshot(tied, masters_only).bulk.point_data["J"]
    assert jacobian == pytest.approx(np.linalg.det(STRETCHED), rel=1e-9)


def test_an_inverted_element_has_no_stress():
    problem = problem_of(rings(), 2)
    mirrored = problem.space.affine(np.diag([-2.0, 0.0]), np.zeros(2))
    bulk = snapshot(problem, mirrored).bulk
    assert bulk.point_data["J"] == pytest.approx(-1)
    assert np.isnan(bulk.point_data["von_mises"]).all()


def test_a_mesh_of_two_kinds_of_elements_is_refused():
    mesh = meshing.Mesh()
    mesh.dim = 2
    mesh.AddPoints(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5]], dtype=float))
    region = mesh.AddRegion("cell0", dim=2)
    for nodes in ([[0, 1, 2, 3]], [[1, 4, 2]]):
        mesh.AddElements(dim=2, index=region, data=np.array(nodes, dtype=np.int32), base=0)
    bodies = BodyMesh(ngsolve.Mesh(mesh), np.zeros(2, dtype=np.int64), ("cell0",), "wall", 1.0, 1.0)
    with pytest.raises(GeometryError, match="the mesh holds QUAD, TRIG"):
        element_type(DisplacementSpace(bodies, 1))
