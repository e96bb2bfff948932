"""What cells hold: pressures by cell, and elements that fill a lumen without locking."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.geometry.filling import lumen_quads
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.rings import sweep
from ngcell.geometry.sections import ring_mesh
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.mechanics.laws.custom import CustomLaw
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.symbolic import EnergyForm
from ngcell.mechanics.symbolic_sum import SymbolicSum
from ngcell.results.jacobian import smallest_jacobian
from ngcell.scene import CellPressure, MeshChoice, Pressure, Tissue

WALL, FILLING = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0), MooneyRivlin(c1=0.01, c2=0.0, bulk_modulus=100.0)


def area(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    one, two = points[quads[:, 2]] - points[quads[:, 0]], points[quads[:, 3]] - points[quads[:, 1]]
    return (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / 2


@pytest.mark.parametrize("edges", [1, 2, 5])
@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_quads_fill_the_lumen_and_keep_the_nodes_of_its_wall(edges, radius):
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    outline = sweep(lattice.outlines, wall=0.1, radius=radius, edges=edges, layers=1).nodes[-1]
    (points,), quads = lumen_quads(outline[None])
    per_side = len(outline) // 6
    assert len(points) == 3 * per_side * (per_side - 1) + 1 and len(quads) == 3 * per_side**2
    areas = area(np.concatenate([outline, points]), quads)
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(1.5 * np.sqrt(3) * (1 - 0.1 / lattice.apothem) ** 2, rel=1e-12)
    assert set(range(len(outline))) <= set(quads.ravel())


def filled_cell(order: int) -> tuple[DisplacementSpace, EnergyForm]:
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    bodies = ring_mesh(lattice.outlines, wall=0.1, radius=0.0, edges=2, layers=1, supports={}, filled=True)
    space = DisplacementSpace(bodies, order)
    return space, SymbolicSum([BodyEnergy(space, [WALL]), InclusionEnergy(space, FILLING)]).form


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_filled_cell_has_one_energy(order):
    space, bulk = filled_cell(order)
    rng = np.random.default_rng(3)
    at = 0.01 * rng.standard_normal(space.unknowns)
    way = rng.standard_normal(space.unknowns)
    step = 1e-6
    slope = (bulk.energy(at + step * way) - bulk.energy(at - step * way)) / (2 * step)
    assert bulk.gradient(at) @ way == pytest.approx(slope, rel=1e-6)
    bent = (bulk.gradient(at + step * way) - bulk.gradient(at - step * way)) / (2 * step)
    product = bulk.tangent(at) @ way
    np.testing.assert_allclose(product, bent, atol=2e-5 * np.abs(bent).max())


def test_a_stretched_filling_stores_its_own_energy_beside_that_of_the_wall():
    space, bulk = filled_cell(2)
    gradient = np.array([[0.1, 0.0], [0.0, -0.05]])
    state = space.affine(gradient, np.zeros(2)).ravel()
    full = 1.5 * np.sqrt(3)
    inner = full * (1 - 0.1 / (np.sqrt(3) / 2)) ** 2
    assert bulk.energy(state) == pytest.approx(
        density(WALL, gradient) * (full - inner) + density(FILLING, gradient) * inner, rel=1e-10
    )
    element = np.arange(space.mesh.ne)
    gradients = np.tile(np.eye(3), (len(element), 1, 1))
    gradients[:, :2, :2] += gradient
    laws = {FILLING: InclusionEnergy(space, FILLING), WALL: BodyEnergy(space, [WALL])}
    for law, term in laws.items():
        stress, members = term.stress(gradients, element), space.bodies.is_filling == (law is FILLING)
        np.testing.assert_array_equal(stress[members], law.cauchy_stress(gradients[members]))
        assert members.sum() == 12 and not stress[~members].any()


def density(law: MooneyRivlin, gradient: np.ndarray) -> float:
    stretch = np.eye(3)
    stretch[:2, :2] += gradient
    jacobian = np.linalg.det(stretch)
    left = stretch @ stretch.T / jacobian ** (2 / 3)
    first = np.trace(left)
    second = (first**2 - np.trace(left @ left)) / 2
    return law.c1 / 2 * (first - 3) + law.c2 / 2 * (second - 3) + law.bulk_modulus / 2 * np.log(jacobian) ** 2


def test_cells_under_the_same_pressure_share_a_region_and_empty_ones_have_no_load():
    tissue = Tissue(rows=2, cols=3, wall=0.1)
    lumen = CellPressure(pressure=((0.0, 0.2, 0.1), (0.2, 0.2, 0.0)))
    regions = lumen.regions(tissue)
    assert [cells.tolist() for cells in regions.values()] == [[0, 5], [2], [1, 3, 4]]
    space = DisplacementSpace(tissue.mesh("plates", MeshChoice(size=0.5), regions), 2)
    (term,) = lumen.terms(space, PrescribedMotion(space, []), tissue, WALL)
    term.apply(1.0)
    at = space.configuration(0.01 * np.random.default_rng(5).standard_normal(space.unknowns))
    alone = AppliedLoads(
        space,
        [Pressure(boundary="lumen1", value=0.1), Pressure(boundary="lumen2", value=0.2)],
        PrescribedMotion(space, []),
    )
    alone.apply(1.0)
    assert term.value(at) != 0 and term.value(at) == pytest.approx(alone.value(at), rel=1e-12)
    assert not np.any(term.gradient(at)[np.isin(np.tile(space.body_of_unknown, 2), [0, 5])])
    assert term.cell_fields(at, 1.0)["cell_pressure"].tolist() == [0.0, 0.2, 0.1, 0.2, 0.2, 0.0]
    assert len(CellPressure(pressure=0.3).regions(tissue)) == 1


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_pressure_of_a_filling_is_that_of_its_volume(order):
    space, _ = filled_cell(order)
    gradient = np.array([[0.1, 0.2], [0.0, -0.15]])
    jacobian = np.linalg.det(np.eye(2) + gradient)
    state = space.configuration(space.affine(gradient, np.zeros(2)).ravel())
    found = InclusionEnergy(space, FILLING).cell_fields(state, 1.0)
    assert found["cell_pressure"] == pytest.approx([-FILLING.bulk_modulus * np.log(jacobian) / jacobian], rel=1e-10)


def neo_hookean(gradient: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
    return 0.5 * (ngsolve.InnerProduct(gradient, gradient) - 3) - ngsolve.log(ngsolve.Det(gradient))


def test_the_pressure_in_a_lumen_is_that_of_its_law_whichever_parts_its_energy_has():
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    bodies = ring_mesh(lattice.outlines, wall=0.1, radius=0.0, edges=1, layers=1, supports={}, filled=True)
    space = DisplacementSpace(bodies, 1)
    gradient = np.array([[1.1, 0.2, 0.0], [0.1, 0.8, 0.0], [0.0, 0.0, 1.0]])
    at = space.configuration(space.affine(gradient[:2, :2] - np.eye(2), np.zeros(2)).ravel())
    law = CustomLaw(neo_hookean)
    expected = -np.trace(law.cauchy_stress(gradient[None])[0]) / 3
    assert abs(expected) > 0.01
    found = InclusionEnergy(space, law).cell_fields(at, 1.0)["cell_pressure"]
    assert found == pytest.approx([expected], rel=1e-10)


def test_a_filling_cannot_fold_at_a_corner_of_its_lumen():
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    bodies = ring_mesh(lattice.outlines, wall=0.1, radius=0.0, edges=2, layers=1, supports={}, filled=True)
    space = DisplacementSpace(bodies, 2)
    term = InclusionEnergy(space, FILLING)
    points = np.array([vertex.point for vertex in bodies.mesh.vertices])
    elements = list(bodies.mesh.Elements())
    filling = [element for element in elements if element.mat == "filling"]
    inside = np.unique([vertex.nr for element in filling for vertex in element.vertices])
    farthest = inside[np.linalg.norm(points[inside], axis=1).argmax()]
    at = np.zeros((2, space.size))
    at[:, farthest] = -0.52 * points[farthest]
    assert -0.1 < smallest_jacobian(space, at.ravel()).value < 0
    state = space.configuration(at.ravel())
    assert np.isnan(term.value(state))
    assert np.isfinite(term.finer(1).value(state))  # as many Gauss points as the order takes
