"""Bonds between solids: one energy with its forces and stiffness, and points that cover what coincides once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ngcell.contact.cohesion.bonds import Bonds, bond_walls
from ngcell.contact.cohesion.exponential import Cohesion
from ngcell.contact.methods.terms import CohesionTerm
from ngcell.contact.surface.find import find_surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.problem import Problem
from tests.contact.derivatives import assert_derivatives, smooth_step
from tests.contact.solids import Pair, blocks, straddling

LAW = Cohesion(strength=0.3, energy=0.02)


def prisms(order: int) -> Pair:
    """Two prisms that touch along a wall of length 1 and height 0.6, at x = 3^0.5 / 2."""
    lattice = hexagonal_lattice(1, 2, side=1.0, pointy=True)
    section = ring_section(lattice.outlines, wall=0.2, radius=0.0, edges=1, layers=1, supports={})
    return Pair(DisplacementSpace(prism_mesh(section, height=0.6, slices=2), order))


def bonded(bodies: Pair) -> tuple[Problem, Bonds]:
    problem, bonds = bodies.problem, bond_walls(bodies.walls, LAW)
    return Problem(problem.space, [*problem.terms, CohesionTerm(bonds)], bodies.nowhere), bonds


@pytest.mark.parametrize("before", [0.0, 0.5, 2.0], ids=["loading", "mixed", "unloading"])
@pytest.mark.parametrize(
    ("make", "order", "translation"),
    [
        (blocks, 1, (0.02, 0.03, -0.01)),
        (blocks, 2, (0.02, 0.03, -0.01)),
        (straddling, 2, (0.0, 0.02, 0.04)),
        (prisms, 2, (-0.01, 0.02, 0.01)),
        (prisms, 3, (0.04, 0.02, 0.03)),
    ],
)
def test_forces_and_tangent_are_derivatives_of_one_energy(make, order, translation, before):
    """Surface apart and pressed, bonds that open further and that have been opened more."""
    bodies = make(order)
    problem, bonds = bonded(bodies)
    at, way = bodies.moved(translation, 0.03, 3), bodies.bent(1.0, 8)
    positions = problem.configuration(at).positions
    bonds.largest = before * np.median(bonds.openings(positions)) * np.ones_like(bonds.largest)
    assert_derivatives(problem, at, way, smooth_step(problem, bonds, at, way), rel=1e-6)


@pytest.mark.parametrize(
    ("make", "order", "low", "high"),
    [
        (blocks, 1, (0.2, 0.15), (0.75, 0.8)),
        (blocks, 3, (0.2, 0.15), (0.75, 0.8)),
        (straddling, 2, (0.6, 0.5), (1.0, 1.0)),
        (prisms, 2, (-0.5, 0.0), (0.5, 0.6)),
    ],
)
def test_bonds_cover_what_coincides_once(make, order, low, high):
    """Area and moments up to the second are those of the rectangle in which walls coincide."""
    bodies = make(order)
    bonds = bond_walls(bodies.walls, LAW)
    a, one, two = bonds.kinematics.vectors(bodies.space.rest)
    np.testing.assert_allclose(a, 0, atol=1e-12)
    place = bodies.walls.places(bonds.kinematics.pairs.primary, bonds.kinematics.pairs.primary_xi, bodies.walls.rest)
    sizes, middle = np.subtract(high, low), np.add(high, low) / 2
    away = (place[:, 1:] if make is prisms else place[:, :2]) - middle
    area = sizes.prod()
    assert bonds.weight.sum() == pytest.approx(area, rel=1e-9)
    np.testing.assert_allclose(bonds.weight @ away, 0, atol=1e-9)
    np.testing.assert_allclose((away.T * bonds.weight) @ away, np.diag(area * sizes**2 / 12), atol=1e-9)
    normal = np.cross(one, two) * bonds.kinematics.side[:, None]
    outward = np.array([1.0, 0.0, 0.0]) if make is prisms else np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(normal / np.linalg.norm(normal, axis=1)[:, None] @ outward, -1, rtol=1e-9)


@pytest.mark.parametrize("make", [blocks, prisms])
def test_opening_and_energy_of_parted_and_sliding_solids(make):
    bodies = make(2)
    bonds = bond_walls(bodies.walls, LAW)
    area = bonds.weight.sum()
    outward = np.array([1.0, 0.0, 0.0]) if make is prisms else np.array([0.0, 0.0, 1.0])
    correction = np.array([0.0, 0.3, 0.4]) if make is prisms else np.array([0.3, 0.4, 0.0])
    for part, opening in ((1.5, 1.5), (40.0, 40.0), (-1.0, 0.0)):
        translation = LAW.peak * (part * outward)
        positions = bodies.space.rest + translation[:, None] * bodies.upper
        np.testing.assert_allclose(bonds.openings(positions) ** 2, (opening * LAW.peak) ** 2, rtol=1e-9, atol=1e-16)
        work = float(LAW.work(np.array(opening * LAW.peak)))
        assert bonds.energy(positions) == pytest.approx(area * work, rel=1e-9, abs=1e-15)
    pressed = LAW.peak * (2 * correction - 3 * outward)
    np.testing.assert_allclose(bonds.openings(bodies.space.rest + pressed[:, None] * bodies.upper), LAW.peak, rtol=1e-9)


def test_a_rigid_motion_of_all_costs_nothing_and_turns_the_forces():
    bodies = prisms(2)
    bonds = bond_walls(bodies.walls, LAW)
    at = bodies.problem.configuration(bodies.moved((0.02, 0.03, 0.01), 0.03, 3)).positions
    turn = Rotation.from_rotvec([0.4, -0.7, 0.5]).as_matrix()
    turned = turn @ at + np.array([[0.3], [-0.2], [0.1]]) * bodies.space.one
    assert bonds.energy(turned) == pytest.approx(bonds.energy(at), rel=1e-12)
    force, force_turned = (bonds.gradient(place).reshape(3, -1) for place in (at, turned))
    np.testing.assert_allclose(force_turned, turn @ force, atol=1e-12)
    np.testing.assert_allclose(force @ bodies.space.one, 0, atol=1e-13)
    np.testing.assert_allclose(np.cross(at, force, axis=0).sum(1), 0, atol=1e-12)


def test_every_wall_of_a_prism_tissue_is_bonded():
    lattice = hexagonal_lattice(2, 2, side=1.0, pointy=True)
    section = ring_section(lattice.outlines, wall=0.2, radius=0.0, edges=1, layers=1, supports={})
    space = DisplacementSpace(prism_mesh(section, height=0.6, slices=2), 1)
    bonds = bond_walls(find_surface(space.bodies, space.scalar, space.rest), LAW)
    assert len(np.unique(bonds.bodies, axis=0)) == 5
    assert bonds.weight.sum() == pytest.approx(5 * 0.6, rel=1e-9)
