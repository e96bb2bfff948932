"""Mortar contact of solids: one energy with its forces and stiffness, and the functions that pressures are made of."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.multipliers import SHARP, MultiplierSpace, constrained_points
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.problem import Problem
from tests.contact.derivatives import assert_derivatives, step_between_kinks
from tests.contact.solids import LAW, Pair, balls, blocks, straddling
from tests.tissues import NOTHING, contact_set, contact_term, small_tissue


def prisms(order: int, edges: int = 2) -> Pair:
    """Two prisms of height 0.6 that touch along a wall."""
    lattice = hexagonal_lattice(1, 2, side=1.0, pointy=True)
    section = ring_section(lattice.outlines, wall=0.2, radius=0.0, edges=edges, layers=1, supports={})
    return Pair(DisplacementSpace(prism_mesh(section, height=0.6, slices=2), order))


def pressed(bodies: Pair, normal_force: float) -> Problem:
    """Contact with multipliers above 0, each of its own."""
    stiffness = penalty_stiffness(bodies.walls, np.full(2, LAW.plane_strain_modulus), 10.0)
    contact = MortarContact(bodies.walls, stiffness, 0.4)
    size = contact.space.size
    contact.multipliers[:size] = normal_force * stiffness[0] * np.random.default_rng(1).uniform(0.5, 1, size)
    return Problem(bodies.space, [bodies.bulk, ContactTerm(contact)], bodies.nowhere)


@pytest.mark.parametrize("normal_force", [0.0, 0.05])
@pytest.mark.parametrize(
    ("make", "order", "translation"),
    [
        (blocks, 1, (0.01, 0.02, -0.03)),
        (blocks, 2, (0.01, 0.02, -0.03)),
        (blocks, 3, (0.01, 0.02, -0.01)),
        (straddling, 2, (0.01, 0.02, -0.03)),
        (balls, 2, (0.01, 0.02, -0.03)),
        (prisms, 2, (-0.03, 0.05, 0.02)),
        (prisms, 3, (-0.03, 0.05, 0.02)),
    ],
)
def test_forces_and_tangent_are_derivatives_of_one_energy(make, order, translation, normal_force):
    bodies = make(order)
    problem = pressed(bodies, normal_force)
    at, way = bodies.moved(translation, 0.03, 3), bodies.bent(1.0, 8)
    state = problem.at(at)
    gap, slopes, _ = contact_set(problem, state).penalty_terms(state.positions)
    assert (gap < 0).any()
    assert_derivatives(problem, at, way, step_between_kinks(gap, slopes @ way), rel=1e-6)


@pytest.mark.parametrize("make", [blocks, prisms])
@pytest.mark.parametrize("depth", [-0.02, 0.01])
def test_weighted_gaps_of_a_rigid_translation_are_the_translation(make, depth):
    """Where a function's wall is faced all over, its gap is the distance; where it is faced in part, a share of it."""
    bodies = make(2)
    problem = pressed(bodies, 0.0)
    outward = np.array([1.0, 0.0, 0.0]) if make is prisms else np.array([0.0, 0.0, 1.0])
    state = problem.at((-depth * outward[:, None] * bodies.upper).ravel())
    contact = contact_set(problem, state)
    along = contact.rows < contact_term(problem).method.space.size
    gaps = (contact.weighted_gaps(state.positions) / -depth)[along]
    assert gaps.max() == pytest.approx(1, abs=1e-9)
    assert gaps.min() > 0
    # Their sum over all functions is the area that is faced.
    area = 0.6 if make is prisms else 0.55 * 0.65
    assert gaps @ contact.weight[along] == pytest.approx(area, rel=1e-8)


def test_updated_pressures_stand_for_the_gaps_that_they_close():
    bodies = blocks(2)
    problem = pressed(bodies, 0.0)
    state = problem.at(bodies.moved((0.0, 0.0, -0.02), 0.0, 3))
    contact, method, positions = contact_set(problem, state), contact_term(problem).method, state.positions
    before = contact.pressures(positions)
    missed, energy = method.update_multipliers(contact, positions, NOTHING)
    assert missed == pytest.approx(0.02, rel=1e-6) and energy > 0
    again = method.pair(positions)
    np.testing.assert_allclose(method.multipliers[again.rows], before, atol=1e-9 * before.max())


def walls_of(order: int) -> Surface:
    """Three edges a wall."""
    return prisms(order, edges=3).walls


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("make", [blocks, prisms])
def test_functions_are_positive_add_up_to_one_and_cover_the_walls(order, make):
    walls = make(order).walls
    space = MultiplierSpace(walls)
    points = np.random.default_rng(2).dirichlet(np.ones(3), 50)[:, :2]
    values = space.values(points)
    assert (values > 0).all()
    np.testing.assert_allclose(values.sum(1), 1, atol=1e-13)
    assert (space.weight > 0).all()
    assert space.weight.sum() == pytest.approx(walls.weights.sum(), rel=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("make", [blocks, balls, prisms])
def test_pressures_are_continuous_but_at_sharp_sides(make, order):
    """At points of sides that faces share."""
    walls = make(order).walls
    space = MultiplierSpace(walls)
    coefficients = np.random.default_rng(3).uniform(size=space.size)
    basis = walls.basis
    ahead = np.roll(basis.corners, -1, axis=0) - basis.corners
    at = np.concatenate([basis.corners + part * ahead for part in (0.3, 0.7)])
    face = np.repeat(np.arange(walls.facet_count), len(at))
    xi = np.tile(at, (walls.facet_count, 1))
    side = np.tile(np.arange(len(basis.corners)), len(face) // len(basis.corners))
    value = (space.values(xi) * coefficients[space.row[face]]).sum(1)
    place = walls.places(face, xi, walls.rest)
    body = walls.body[face]
    key = np.column_stack([body, np.round(place, 7)])
    _, number, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    number = number.ravel()
    order_of = np.argsort(number, kind="stable")
    one = order_of[np.flatnonzero(np.diff(number[order_of]) == 0)]
    two = order_of[np.flatnonzero(np.diff(number[order_of]) == 0) + 1]
    smooth = np.abs(walls.exterior_angle[face[one], side[one]]) < SHARP
    assert smooth.sum() > 10 and count.max() == 2
    np.testing.assert_allclose(value[one[smooth]], value[two[smooth]], atol=1e-12)
    if make is not balls:
        assert (np.abs(value[one[~smooth]] - value[two[~smooth]]) > 1e-3).mean() > 0.9


@pytest.mark.parametrize(("order", "along"), [(1, 3), (2, 3), (3, 5)])
def test_prisms_have_the_functions_of_their_section_times_those_along_the_axis(order, along):
    """Corner lines are sharp, ends are not; two slices along the axis."""
    planar = MultiplierSpace(small_tissue(1, 2, order=order, edges=3).walls)
    assert MultiplierSpace(walls_of(order)).size == planar.size * along


def test_constrained_points_are_vertices_and_quarters_each_once():
    walls = walls_of(2)
    points = constrained_points(walls)
    edge, xi = points.facet, points.xi
    place = walls.places(edge, xi, walls.rest)
    assert len(np.unique(np.column_stack([walls.body[edge], np.round(place, 7)]), axis=0)) == len(edge)
    assert len(edge) == 2 * (6 * 3 * 4) * (2 * 4 + 1)
    assert (np.diff(edge) >= 0).all()
