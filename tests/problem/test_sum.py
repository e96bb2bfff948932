"""A problem is the sum of its terms: each gives forces and tangent of one energy, on both sides of its kinks."""

from __future__ import annotations

from collections.abc import Callable

import ngsolve
import numpy as np
import pytest
from scipy import sparse

from ngcell.build.simulation import Simulation
from ngcell.contact.cohesion.bonds import bond_walls
from ngcell.contact.cohesion.exponential import Cohesion
from ngcell.contact.methods.terms import CohesionTerm, ContactTerm
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.fluid import LumenFluids
from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.symbolic import OwnEnergy
from ngcell.mechanics.term import Configuration, OneSided, Role, Term
from ngcell.problem.problem import Problem
from ngcell.scene import BodyForce, Pressure
from tests.contact.derivatives import assert_derivatives
from tests.prisms import case
from tests.tissues import LAW, LONGEST_STEP, SmallTissue, small_tissue

SOFT = MooneyRivlin(c1=0.05, c2=0.02, bulk_modulus=3.0)
BED = 0.7


class Floor(Term):
    """Vertices may not sink below a height: a user's own one-sided term, with penalty terms of a given stiffness."""

    def __init__(self, space: DisplacementSpace, height: float, stiffness: float = 30.0) -> None:
        self._vertex = space.size + np.flatnonzero(space.one)
        self._height, self._stiffness, self._unknowns = height, stiffness, space.unknowns

    def value(self, at: Configuration) -> float:
        constraints = self.constraints(at)
        return float((constraints.penalty * np.minimum(constraints.gap, 0) ** 2).sum() / 2)

    def gradient(self, at: Configuration) -> np.ndarray:
        return np.zeros(self._unknowns)

    def constraints(self, at: Configuration) -> OneSided:
        gap, row = at.positions.ravel()[self._vertex] - self._height, np.arange(len(self._vertex))
        jacobian = sparse.csr_array((np.ones(len(row)), (row, self._vertex)), shape=(len(row), self._unknowns))
        return OneSided(gap, jacobian, np.full(len(row), self._stiffness), row)


class Link(Term):
    """An elastic link along x between two vertices: a user's own term, with a tangent beyond any pattern."""

    def __init__(self, space: DisplacementSpace, ends: np.ndarray, stiffness: float = 20.0) -> None:
        self._ends, self._stiffness, self._unknowns = ends, stiffness, space.unknowns

    def _stretch(self, at: Configuration) -> float:
        return float(at.positions[0, self._ends] @ [-1.0, 1.0])

    def value(self, at: Configuration) -> float:
        return self._stiffness / 4 * self._stretch(at) ** 4

    def gradient(self, at: Configuration) -> np.ndarray:
        force = self._stiffness * self._stretch(at) ** 3
        return np.bincount(self._ends, [-force, force], self._unknowns)

    def curvature(self, at: Configuration) -> sparse.coo_array:
        values = 3 * self._stiffness * self._stretch(at) ** 2 * np.array([1.0, -1.0, -1.0, 1.0])
        return sparse.coo_array((values, (self._ends.repeat(2), np.tile(self._ends, 2))), shape=(self._unknowns,) * 2)

    def couplings(self, at: Configuration, margin: float) -> tuple[np.ndarray, np.ndarray]:
        return self._ends.repeat(2), np.tile(self._ends, 2)


def cells(order: int, *, filled: bool = False) -> SmallTissue:
    """Two cells that nothing holds, hollow or filled."""
    lattice = hexagonal_lattice(1, 2, side=1.0, pointy=True)
    bodies = ring_mesh(lattice.outlines, wall=0.2, radius=0.0, edges=2, layers=1, supports={}, filled=filled)
    space = DisplacementSpace(bodies, order)
    return SmallTissue(lattice, bodies, space, PrescribedMotion(space, []))


def loads(tissue: SmallTissue) -> AppliedLoads:
    given = [Pressure(boundary="lumen", value=0.4), BodyForce(body="cell0", vector=(0.3, -0.2))]
    found = AppliedLoads(tissue.space, given, tissue.motion)
    found.apply(0.7)
    return found


def fluids(tissue: SmallTissue) -> LumenFluids:
    found = LumenFluids(tissue.space, "lumen", modulus=0.7, fill=1.1)
    found.apply(1.0)
    found.pressure = np.array([0.3, -0.2])
    return found


def cohesion(tissue: SmallTissue, before: float = 0.0) -> CohesionTerm:
    term = CohesionTerm(bond_walls(tissue.walls, Cohesion(strength=0.3, energy=0.02)))
    term.bonds.largest = before * np.ones_like(term.bonds.largest)
    return term


def bed(tissue: SmallTissue) -> OwnEnergy:
    """An elastic bed along all boundaries, the stiffer, the farther they are off."""
    return OwnEnergy(tissue.space, lambda u, mesh: BED / 4 * ngsolve.InnerProduct(u, u) ** 2 * ngsolve.ds)


Make = Callable[[SmallTissue], Term]
#: Terms, and how deep the right cell is pressed into the left one: on both sides of kinks, where there are any.
TERMS: dict[str, tuple[Make, float]] = {
    "bodies": (lambda tissue: tissue.bulk, 0.0),
    "inclusion": (lambda tissue: InclusionEnergy(tissue.space, SOFT), 0.0),
    "loads": (loads, 0.0),
    "fluids": (fluids, 0.0),
    "own energy": (bed, 0.0),
    "own curvature": (lambda tissue: Link(tissue.space, np.flatnonzero(tissue.space.one)[[0, -1]]), 0.0),
    "open walls": (lambda tissue: ContactTerm(tissue.contact), -0.04),
    "closed walls": (lambda tissue: ContactTerm(tissue.contact), 0.04),
    "bonds that open": (cohesion, -0.04),
    "bonds that have been opened more": (lambda tissue: cohesion(tissue, 0.3), -0.04),
    "bonds of pressed walls": (cohesion, 0.04),
    "own constraints, open": (lambda tissue: Floor(tissue.space, -3.0), 0.0),
    "own constraints, closed in part": (lambda tissue: Floor(tissue.space, -0.2), 0.0),
    "own constraints, closed": (lambda tissue: Floor(tissue.space, 3.0), 0.0),
}
#: Names of terms that may act together: all effects at once, walls open and closed.
TOGETHER = {
    "apart": (["bodies", "loads", "fluids", "own energy", "own curvature", "open walls", "bonds that open"], -0.04),
    "pressed": (["bodies", "loads", "own energy", "closed walls", "bonds of pressed walls"], 0.04),
    "filled": (["bodies", "inclusion", "own energy", "closed walls"], 0.04),
    "two kinds of constraints": (["bodies", "closed walls", "own constraints, closed in part"], 0.04),
}


def sum_of(tissue: SmallTissue, *names: str) -> Problem:
    terms = [TERMS[name][0](tissue) for name in names]
    return Problem(tissue.space, terms, np.zeros((2, tissue.space.size), dtype=bool))


def tissue_for(order: int, *names: str) -> SmallTissue:
    return cells(order, filled="inclusion" in names)


def place(tissue: SmallTissue, depth: float) -> np.ndarray:
    return tissue.smooth(0.02, 3) + tissue.body_translation(1, np.array([-depth, 0.1]))


def sides(problem: Problem, displacement: np.ndarray) -> np.ndarray:
    """On which side of each kink a place lies."""
    state = problem.at(displacement)
    keys, gaps = problem.gaps(state)
    found = [keys, gaps > 0]
    for term in problem.terms:
        if isinstance(term, CohesionTerm):
            opening, height = term.bonds.openings(state.positions), term.bonds.kinematics.gaps(state.positions)
            found += [height > 0, opening > term.bonds.largest]
    return np.concatenate(found)


def smooth_step(problem: Problem, at: np.ndarray, way: np.ndarray) -> float:
    """A step that crosses no kink."""
    step = 1e-5
    while not all(np.array_equal(sides(problem, at), sides(problem, at + sign * step * way)) for sign in (-1, 1)):
        step /= 2
        assert step > 1e-9
    return step


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("name", TERMS)
def test_forces_and_tangent_of_each_term_are_derivatives_of_its_value(name, order):
    tissue = tissue_for(order, name)
    problem, at, way = sum_of(tissue, name), place(tissue, TERMS[name][1]), tissue.smooth(1.0, 8)
    gap = problem.gaps(problem.at(at))[1]
    assert {"open": (gap > 0).all(), "closed": (gap < 0).any()}.get(name.split()[0], True)
    if "in part" in name:
        assert (gap < 0).any() and (gap > 0).any()
    assert_derivatives(problem, at, way, smooth_step(problem, at, way), rel=1e-6)


@pytest.mark.parametrize("name", TOGETHER)
def test_forces_and_tangent_of_a_sum_are_derivatives_of_its_value(name):
    names, depth = TOGETHER[name]
    tissue = tissue_for(2, *names)
    problem, at, way = sum_of(tissue, *names), place(tissue, depth), tissue.smooth(1.0, 8)
    assert_derivatives(problem, at, way, smooth_step(problem, at, way), rel=1e-6)


@pytest.mark.parametrize("name", TOGETHER)
def test_a_sum_has_the_values_forces_and_constraints_of_its_terms(name):
    names, depth = TOGETHER[name]
    tissue = tissue_for(2, *names)
    problem, parts = sum_of(tissue, *names), [sum_of(tissue, part) for part in names]
    at = place(tissue, depth)
    whole, alone = problem.at(at), [part.at(at) for part in parts]
    assert whole.energy == pytest.approx(sum(state.energy for state in alone), rel=1e-12)
    force = sum(part.gradient(state) for part, state in zip(parts, alone, strict=True))
    np.testing.assert_allclose(problem.gradient(whole), force, atol=1e-12 * np.abs(force).max())
    by_role = sum(problem.force(whole.at, role) for role in Role)
    np.testing.assert_allclose(by_role, force, atol=1e-12 * np.abs(force).max())
    assert problem.unstored(whole.at) == pytest.approx(
        sum(part.unstored(state.at) for part, state in zip(parts, alone, strict=True)), rel=1e-12
    )
    line = problem.linearise(whole)
    assert len(line.gap) == sum(len(part.gaps(state)[1]) for part, state in zip(parts, alone, strict=True))
    keys, gaps = problem.gaps(whole)
    assert len(np.unique(keys)) == len(keys)
    order = np.argsort(line.keys)
    np.testing.assert_array_equal(line.keys[order], keys)
    np.testing.assert_array_equal(line.gap[order], gaps)


def test_a_load_that_takes_away_what_is_stored_makes_no_energy_small():
    """Energies are small beside what bodies store, also where potentials of loads make up for it."""
    tissue = cells(2)
    at, bodies, both = place(tissue, 0.0), sum_of(tissue, "bodies"), sum_of(tissue, "bodies", "loads")
    stored = bodies.magnitude(bodies.at(at))
    assert stored == bodies.at(at).energy > 0
    term = both.terms[1]
    term.apply(-stored / term.potential(at, 1.0))
    state = both.at(at)
    assert abs(state.energy) < 1e-12 * stored
    assert both.magnitude(state) == pytest.approx(stored, rel=1e-12)


def test_the_order_of_terms_changes_nothing():
    tissue = cells(2)
    names, depth = TOGETHER["apart"]
    at = place(tissue, depth)
    one, two = sum_of(tissue, *names), sum_of(tissue, *reversed(names))
    assert two.at(at).energy == pytest.approx(one.at(at).energy, rel=1e-12)
    force = one.gradient(one.at(at))
    np.testing.assert_allclose(two.gradient(two.at(at)), force, atol=1e-12 * np.abs(force).max())


@pytest.mark.parametrize("parts", [[5.0], [2.0, 3.0]], ids=["one integral", "two"])
def test_an_own_energy_is_added_up(parts):
    """A bed of stiffness 5 along the plate that is held: moved by (3, 4), it stores 25 / 2 times 5 for each length."""
    tissue = small_tissue(1, 2)
    length = float(ngsolve.Integrate(ngsolve.CF(1) * ngsolve.ds("low"), tissue.bodies.mesh))

    def integrals(u: ngsolve.CoefficientFunction, mesh: ngsolve.Mesh) -> object:
        found = [stiffness / 2 * ngsolve.InnerProduct(u, u) * ngsolve.ds("low") for stiffness in parts]
        return found if len(found) > 1 else found[0]

    own = OwnEnergy(tissue.space, integrals)
    problem = Problem(tissue.space, [tissue.bulk, own], tissue.motion.fixed)
    assert problem.terms == (tissue.bulk, own)
    moved = tissue.rigid_motion(0.0, (3.0, 4.0))
    state = problem.at(moved)
    assert length > 0 and state.energy == pytest.approx(5 * 25 / 2 * length, rel=1e-11)
    force = problem.gradient(state).reshape(2, -1) @ tissue.space.one
    np.testing.assert_allclose(force, 5 * np.array([3.0, 4.0]) * length, rtol=1e-9)
    assert problem.unstored(state.at) == 0
    np.testing.assert_array_equal(problem.force(state.at, Role.LOAD), 0)


def test_a_simulation_takes_own_terms_tied_and_released():
    def stiff(space: DisplacementSpace) -> OwnEnergy:
        return OwnEnergy(space, lambda u, mesh: 3 * u[0] ** 2 * ngsolve.dx)

    simulation = Simulation(case(None), terms=[stiff])
    space = simulation.space
    volume = float(space.one @ space.scalar_mass @ space.one)
    moved = space.affine(np.zeros((2, 2)), np.array([2.0, 0.0])).ravel()
    for problem in (*simulation.tied_problems, *simulation.released_problems, simulation.released.apart.problem):
        assert problem.at(moved).energy == pytest.approx(12 * volume, rel=1e-9)


def test_an_inverted_element_leaves_the_sum_without_energy():
    tissue = cells(1)
    problem = sum_of(tissue, "closed walls", "bodies")
    mirrored = tissue.space.affine(np.diag([-2.0, 0.0]), np.zeros(2)).ravel()
    assert np.isnan(problem.at(mirrored).energy)


def test_what_a_term_finds_at_a_place_is_found_once():
    tissue = cells(1)
    contact = ContactTerm(tissue.contact)
    at = tissue.space.configuration(place(tissue, 0.04))
    assert contact.found(at) is contact.found(at)
    assert ContactTerm(tissue.contact).found(at) is not contact.found(at)
    assert contact.found(tissue.space.configuration(at.displacement)) is not contact.found(at)
    assert LONGEST_STEP < tissue.contact.reach


def test_only_fluids_and_loads_are_driven_and_only_bodies_soften():
    tissue = cells(1)
    problem = sum_of(tissue, *TOGETHER["apart"][0])
    at = place(tissue, -0.04)
    assert [type(term) for term in problem.terms if term.drive(tissue.space.configuration(at), 1.0)] == [
        AppliedLoads,
        LumenFluids,
    ]
    filled = sum_of(cells(1, filled=True), *TOGETHER["filled"][0])
    for one in (problem, filled):
        softened = {type(term) for term in one.terms if term.softened(1.0) is not term}
        assert softened == ({BodyEnergy, InclusionEnergy} if one is filled else {BodyEnergy})
        assert softened == {type(term) for term in one.terms if term.incompressibility > 0}
    ratios = [term.incompressibility for term in filled.terms[:2]]
    assert ratios == [law.bulk_modulus / law.shear_modulus for law in (LAW, SOFT)]


@pytest.mark.parametrize("is_tied", [False, True])
def test_the_metric_measures_displacements_and_their_gradients_over_the_diameter_of_a_body(is_tied):
    tissue = cells(2, filled=True)
    fixed = np.zeros((2, tissue.space.size), dtype=bool)
    problem = Problem(tissue.space, [tissue.bulk], fixed, tie=tissue.tie if is_tied else None, length=1.5)
    space, gradient, by = tissue.space, np.array([[0.1, 0.2], [0.3, -0.4]]), (1.0, 2.0)
    everywhere = space.affine(gradient, np.array(by)).ravel()
    of_all = sparse.block_diag([space.scalar_mass] * 2, format="csr")
    moved, *_ = np.linalg.lstsq(problem.mass.tocsr().toarray(), problem.unknowns.gather(of_all @ everywhere))
    np.testing.assert_allclose(problem.expand(moved), everywhere, atol=1e-9)
    place = ngsolve.CF((ngsolve.x, ngsolve.y))
    squared = sum((float(a) * place[0] + float(b) * place[1] + c) ** 2 for (a, b), c in zip(gradient, by, strict=True))
    volume = ngsolve.Integrate(ngsolve.CF(1), space.mesh)
    expected = ngsolve.Integrate(squared, space.mesh) + 3.0**2 * (gradient**2).sum() * volume
    assert moved @ (problem.metric @ moved) == pytest.approx(expected)


@pytest.mark.parametrize("is_tied", [False, True])
def test_a_matrix_of_all_components_is_held_once_and_multiplies_as_all_of_its_entries(is_tied):
    tissue = cells(2, filled=True)
    fixed = np.zeros((2, tissue.space.size), dtype=bool)
    problem = Problem(tissue.space, [tissue.bulk], fixed, tie=tissue.tie if is_tied else None)
    assert problem.metric.of_one is sum_of(tissue, *TOGETHER["filled"][0]).metric.of_one
    vector = np.random.default_rng(0).standard_normal(tissue.space.unknowns)
    for matrix in (problem.metric, problem.mass):
        whole = matrix.tocsr()
        assert (whole != whole.T).nnz == 0
        np.testing.assert_allclose(matrix @ vector, whole @ vector, rtol=1e-12, atol=1e-12 * abs(whole).max())


def test_what_is_given_back_is_made_anew():
    problem = sum_of(cells(2, filled=True), *TOGETHER["filled"][0])
    at = np.random.default_rng(0).uniform(-1e-3, 1e-3, problem.space.unknowns)

    def found() -> tuple[float, np.ndarray]:
        state = problem.at(at)
        return state.energy, problem.linearise(state).stiffness

    energy, stiffness = found()
    form = problem._sum[0].form
    problem.release()
    again = found()
    assert problem._sum[0].form is not form
    assert again[0] == energy and np.array_equal(again[1], stiffness)


@pytest.mark.parametrize("body", [0, 1])
def test_a_body_turned_inside_out_is_told(body):
    tissue = cells(2, filled=True)
    problem, space = sum_of(tissue, *TOGETHER["filled"][0]), tissue.space
    mirrored = space.affine(np.diag([-2.0, 0.0]), np.zeros(2))
    place = np.where(space.body_of_unknown == body, mirrored, 0.0).ravel()
    np.testing.assert_array_equal(problem.folded(problem.at(place)), np.arange(2) == body)


@pytest.mark.parametrize("name", ["bodies", "inclusion"])
def test_what_is_stored_is_known_body_by_body(name):
    tissue = cells(2, filled=True)
    problem, space = sum_of(tissue, name), tissue.space
    place = np.where(space.body_of_unknown == 1, space.affine(np.diag([0.02, 0.01]), np.zeros(2)), 0.0).ravel()
    term, at = problem.terms[0], problem.at(place).at
    stored = term.stored_in_bodies(at)
    assert stored is not None and stored[0] == 0
    assert stored.sum() == pytest.approx(term.value(at), rel=1e-12) and stored[1] > 0


@pytest.mark.parametrize("body", [0, 1])
def test_a_filling_turned_inside_out_is_told(body):
    tissue = cells(2, filled=True)
    problem, space = sum_of(tissue, "inclusion"), tissue.space
    mirrored = space.affine(np.diag([-2.0, 0.0]), np.zeros(2))
    place = np.where(space.body_of_unknown == body, mirrored, 0.0).ravel()
    np.testing.assert_array_equal(problem.folded(problem.at(place)), np.arange(2) == body)


@pytest.mark.parametrize("body", [0, 1])
def test_bodies_that_are_tied_fold_and_are_damped_as_one_solid(body):
    tissue = cells(2, filled=True)
    fixed = np.zeros((2, tissue.space.size), dtype=bool)
    problem, space = Problem(tissue.space, [tissue.bulk], fixed, tie=tissue.tie), tissue.space
    mirrored = space.affine(np.diag([-2.0, 0.0]), np.zeros(2))
    place = np.where(space.body_of_unknown == body, mirrored, 0.0).ravel()
    np.testing.assert_array_equal(problem.folded(problem.at(place)), [True])
    np.testing.assert_array_equal(np.unique(problem.solid), [0])
    apart = Problem(tissue.space, [tissue.bulk], fixed)
    np.testing.assert_array_equal(apart.solid, apart.part)
