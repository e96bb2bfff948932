"""Contact of solids: one energy with its forces and stiffness, on curved faces, at sides and at corners."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.facet_basis import FacetBasis
from ngcell.contact.surface.find import find_surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.near import near_pairs
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.tie import tie_walls
from tests.contact.derivatives import assert_derivatives, step_between_kinks
from tests.contact.solids import Pair, balls, blocks, straddling
from tests.tissues import contact_set, contact_term

SECTION = {"wall": 0.2, "radius": 0.0, "edges": 1, "layers": 1, "supports": {}}


@pytest.mark.parametrize(
    ("make", "order", "depth"),
    [(blocks, 1, 0.03), (blocks, 2, 0.03), (blocks, 3, -0.1), (balls, 2, 0.03), (straddling, 3, 0.03)],
)
def test_forces_and_tangent_are_derivatives_of_one_energy(make, order, depth):
    bodies = make(order)
    problem, at = bodies.problem, bodies.moved((0.01, 0.02, -depth), 0.03, 3)
    state = problem.at(at)
    gap, slopes, _ = contact_set(problem, state).penalty_terms(state.positions)
    assert (gap > 0).all() == (depth < 0)
    way = bodies.bent(1.0, 8)
    assert_derivatives(problem, at, way, step_between_kinks(gap, slopes @ way), rel=1e-6)


@pytest.mark.parametrize(("make", "order"), [(blocks, 1), (balls, 2), (straddling, 2)])
def test_gaps_are_distances_to_second_order(make, order):
    """ContactPairs found anew have the gap that the frozen ones foresee: at feet, on sides and at corners."""
    bodies = make(order)
    positions = bodies.problem.configuration(bodies.moved((0.01, 0.02, 0.1), 0.05, 3)).positions
    way, step = bodies.bent(1.0, 8).reshape(3, -1), 1e-4
    method = contact_term(bodies.problem).method
    here, after, before = (method.pair(positions + size * way) for size in (0.0, step, -step))
    kinds = [kind_of(found.kinematics.pairs) for found in (here, after, before)]
    keys, *places = np.intersect1d(here.keys, after.keys, return_indices=True)
    _, mine, last = np.intersect1d(keys, before.keys, return_indices=True)
    first, second = (place[mine] for place in places)
    same = (kinds[0][first] == kinds[1][second]) & (kinds[0][first] == kinds[2][last])
    first, second, last = first[same], second[same], last[same]
    gap, slopes = here.kinematics.slopes(positions)
    moved = np.concatenate(here.kinematics.vectors(way), axis=1)[first]
    ahead, back = after.gaps(positions + step * way)[second], before.gaps(positions - step * way)[last]
    rise = np.einsum("ni,ni->n", slopes[first], moved)
    bend = np.einsum("ni,nij,nj->n", moved, here.kinematics.curvatures(positions, first), moved)
    assert set(kinds[0][first]) >= ({0, 1} if make is balls else {0, 1, 2})
    np.testing.assert_allclose((ahead - back) / (2 * step), rise, atol=1e-5 * np.abs(rise).max())
    np.testing.assert_allclose((ahead - 2 * gap[first] + back) / step**2, bend, atol=1e-4 * np.abs(bend).max())


@pytest.mark.parametrize("order", [1, 2, 3])
def test_tied_prisms_move_as_one_solid(order):
    """Whatever the masters do: walls that coincide at rest coincide still, at three-cell lines, too."""
    section = ring_section(hexagonal_lattice(2, 2, side=1.0, pointy=True).outlines, **SECTION)
    space = DisplacementSpace(prism_mesh(section, height=0.6, slices=2), order)
    walls = find_surface(space.bodies, space.scalar, space.rest)
    tie = tie_walls(walls, space.size)
    values = tie.sign * np.random.default_rng(2).standard_normal((3, space.size))[:, tie.master]
    field = walls.quadrature_values @ walls.nodes(values)
    place = (walls.quadrature_values @ walls.rest).reshape(-1, 3)
    one, two = near_pairs(place, 1e-6)
    body = np.repeat(walls.body, len(walls.quadrature_points))
    assert (body[one] != body[two]).sum() > 150
    np.testing.assert_allclose(field.reshape(-1, 3)[one], field.reshape(-1, 3)[two], atol=1e-9)


def test_a_rotating_step_turns_bodies_without_stretching_them():
    bodies = balls(2)
    problem, space = bodies.problem, bodies.space
    vector = np.array([0.3, -0.5, 0.4])
    centre = (space.rest * bodies.upper).sum(1) / bodies.upper.sum()
    arm = space.rest - centre[:, None] * space.one
    step = np.cross(vector[:, None], arm, axis=0) * (space.body_of_unknown == 1)
    moved = problem.move(np.zeros(space.unknowns), step.ravel())
    turned = Rotation.from_rotvec(vector).as_matrix() @ arm - arm
    np.testing.assert_allclose(moved.reshape(3, -1), turned * (space.body_of_unknown == 1), atol=1e-12)
    assert abs(bodies.bulk.form.energy(moved)) < 1e-12


@pytest.mark.parametrize("order", [1, 2, 3])
def test_points_of_prisms_lie_on_corner_lines_and_on_no_seam_along_the_axis(order):
    points, weights = FacetBasis(order, 4).rule
    assert {0.0, 1.0} <= set(points[:, 0]) and 0 < points[:, 1].min() <= points[:, 1].max() < 1
    for powers in np.ndindex(2 * order + 2, 2 * order + 2):
        exact = 1 / np.prod(np.add(powers, 1))
        assert weights @ (points**powers).prod(1) == pytest.approx(exact, rel=1e-12)


def test_walls_that_end_are_continued_by_a_quarter():
    """A prism that is raised a little presses on the next one as it did, beyond its end as well."""
    section = ring_section(hexagonal_lattice(1, 2, side=1.0, pointy=True).outlines, **SECTION)
    space = DisplacementSpace(prism_mesh(section, height=0.6, slices=1), 2)
    pair = Pair(space)
    energies = []
    for rise in (0.0, 0.05, 0.14):
        normal_force = np.array([-0.02, 0.0, rise])[:, None] * pair.upper
        contact = contact_term(pair.problem).method.pair(space.rest + normal_force)
        energies.append(contact.energy(space.rest + normal_force))
    assert energies[0] > 0
    np.testing.assert_allclose(energies, energies[0], rtol=1e-9)


def kind_of(pairs: ContactPairs) -> np.ndarray:
    """0 at feet on faces, 1 at feet on sides, 2 at corners."""
    slides = (pairs.slide_direction != 0).any(1)
    return np.where(pairs.at_end, np.where(slides, 1, 2), 0)
