"""Prismatic cells: held along their axis they are planar ones, and between free ends they are softer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from ngcell.build.simulation import Simulation
from tests.prisms import MATERIAL, SOFT, case, last_step

HEIGHT = 0.4


@pytest.mark.parametrize(
    "lumen", [None, {"kind": "pressure", "pressure": 0.01}, {"kind": "inclusion", "material": SOFT}], ids=str
)
def test_prisms_held_along_their_axis_are_planar_cells(lumen):
    planar = last_step(case(None, lumen=lumen))
    solid = last_step(case(HEIGHT, ends="held", lumen=lumen))
    assert planar.record.certified
    assert solid.record.certified
    for name in ("energy", "plate_force_x", "plate_force_y", "contact_force"):
        assert getattr(solid.record, name) == pytest.approx(HEIGHT * getattr(planar.record, name), rel=1e-8), name
    for name in ("largest_gap", "mean_gap", "opened_share"):
        assert getattr(solid.record, name) == pytest.approx(getattr(planar.record, name), rel=1e-6), name
    assert solid.record.plate_force_z == pytest.approx(0, abs=1e-12)


def test_held_prisms_with_balanced_fibres_are_planar_cells():
    """Two families of opposite angles put no shear on a wall along its axis."""
    fibres = {"kind": "exponential", "stiffness": 2.0, "exponent": 5.0, "angles": (30.0, -30.0)}
    material = MATERIAL | {"fibres": fibres}
    planar, bare = last_step(case(None, material=material)), last_step(case(None))
    solid = last_step(case(HEIGHT, ends="held", material=material))
    assert solid.record.certified
    assert planar.record.energy > 1.01 * bare.record.energy
    for name in ("energy", "plate_force_x", "plate_force_y"):
        assert getattr(solid.record, name) == pytest.approx(HEIGHT * getattr(planar.record, name), rel=1e-8), name


def test_prisms_between_free_ends_are_softer_and_certified():
    held, free = last_step(case(HEIGHT, ends="held")), last_step(case(HEIGHT))
    assert free.record.certified
    # Walls bend: of plane strain, 1 - nu^2 is left in plane stress, which the ends are in and the middle less so.
    poisson = (3 * 100 - 2 * 2) / (6 * 100 + 2 * 2)
    assert (1 - poisson**2) * held.record.energy < free.record.energy < held.record.energy


def test_mirrored_prisms_are_one_half_of_those_between_free_ends():
    whole = last_step(case(HEIGHT, mesh={"order": 2, "size": 1.0, "slices": 2}))
    half = last_step(case(HEIGHT / 2, ends="mirrored"))
    assert half.record.certified
    for name in ("energy", "plate_force_x", "contact_force"):
        assert 2 * getattr(half.record, name) == pytest.approx(getattr(whole.record, name), rel=1e-7), name
    assert half.record.mean_gap == pytest.approx(whole.record.mean_gap, rel=1e-6)


def test_a_closed_cell_under_pressure_is_twisted():
    """Six-fold symmetry: the front bears a torque and a thrust, and no force across."""
    scene = case(
        1.0,
        tissue={"rows": 1, "cols": 1, "wall": 0.2, "height": 1.0, "end_wall": 0.2},
        lumen={"kind": "pressure", "pressure": 0.05},
        load={"kind": "ends", "twist": 20.0, "levels": 1},
    )
    simulation = Simulation(scene)
    step = list(simulation.accepted_steps())[-1]
    assert step.record.certified
    across = step.measurement.plate_force[:2]
    assert across == pytest.approx(0, abs=1e-9)
    grid = step.snapshot.bulk
    upper_end = grid.points[:, 2] > 1 - 1e-9
    turned = Rotation.from_euler("z", 20, degrees=True).apply(grid.points[upper_end])
    np.testing.assert_allclose(grid.points[upper_end] + grid.point_data["displacement"][upper_end], turned, atol=1e-12)
    force = step.measurement.reaction.reshape(3, -1)
    place = simulation.space.rest + step.displacement.reshape(3, -1)
    at = simulation.space.region_unknowns("upper-end")
    torque = (place[0] * force[1] - place[1] * force[0])[at].sum()
    # Work of the torque, which grows in proportion to the angle, against the energy that the twist stores.
    untwisted = scene.model_copy(update={"load": scene.load.model_copy(update={"twist": 0.0})})
    rest = last_step(untwisted)
    assert torque * np.radians(20) / 2 == pytest.approx(step.record.energy - rest.record.energy, rel=0.1)


def test_ends_that_tilt_bend_the_axis_to_an_arc_of_its_own_length():
    """The lifting is that of a beam: sections stay plane and across the axis, which keeps its length."""
    angle, height = np.radians(40), 3.0
    scene = case(
        height,
        tissue={"rows": 1, "cols": 1, "wall": 0.1, "height": height},
        load={"kind": "ends", "bend": 40.0, "twist": 30.0, "displacement": (0.1, 0.2, 0.3), "levels": 1},
        mesh={"order": 2, "size": 0.5, "slices": 4},
    )
    simulation = Simulation(scene)
    space = simulation.space
    vertex = space.one > 0
    rest = space.rest[:, vertex]
    moved = rest + simulation.motion.lifting(1.0).reshape(3, -1)[:, vertex]
    share = rest[2] / height
    centre = np.array([moved[:, rest[2] == level].mean(1) for level in np.unique(rest[2])])
    straight = centre - np.linspace(0, 1, 5)[:, None] * [0.1, 0.2, 0.3]
    radius = height / angle
    middle = straight[0] + [radius, 0, 0]
    np.testing.assert_allclose(np.linalg.norm(straight - middle, axis=1), radius, atol=1e-12)
    np.testing.assert_allclose(np.diff(np.arctan2(straight[:, 2], middle[0] - straight[:, 0])), angle / 4, atol=1e-12)
    along = np.array([np.sin(angle * share), np.zeros_like(share), np.cos(angle * share)])
    section = moved - centre[np.searchsorted(np.unique(rest[2]), rest[2])].T
    np.testing.assert_allclose((section * along).sum(0), 0, atol=1e-12)
    upper_end = share == 1
    turned = Rotation.from_euler("zy", [30, 40], degrees=True).apply((rest[:, upper_end] - [[0], [0], [height]]).T)
    axis = rest[:, upper_end].mean(1) - [0, 0, height]
    expected = turned - Rotation.from_euler("zy", [30, 40], degrees=True).apply(axis) + centre[-1]
    np.testing.assert_allclose(moved[:, upper_end].T, expected, atol=1e-12)
    assert np.isfinite(
        simulation.problem.terms[0].value(simulation.space.configuration(simulation.motion.lifting(1.0)))
    )


@pytest.mark.parametrize("turned", [{"twist": 90.0}, {"bend": 120.0}, {"twist": -40.0, "bend": 60.0}])
def test_a_front_that_turns_keeps_its_size_on_the_way(turned):
    """Angles grow with the load, not the displacement of each point, along whose chord the front would shrink."""
    tissue = {"rows": 1, "cols": 1, "wall": 0.1, "height": 3.0}
    simulation = Simulation(case(3.0, tissue=tissue, load={"kind": "ends", "levels": 1} | turned))
    space, motion = simulation.space, simulation.motion
    upper_end = np.flatnonzero((space.one > 0) & (space.rest[2] == 3.0))
    half, whole = (
        space.rest[:, upper_end] + motion.imposed(np.zeros(space.unknowns), factor).reshape(3, -1)[:, upper_end]
        for factor in (0.5, 1.0)
    )
    for moved in (half, whole):
        np.testing.assert_allclose(pdist(moved.T), pdist(space.rest[:, upper_end].T), rtol=1e-12)
    tilt, twist = (np.radians(turned.get(name, 0.0)) for name in ("bend", "twist"))
    across = space.rest[:2, upper_end] - space.rest[:2, upper_end].mean(1)[:, None]
    for share, moved in ((0.5, half), (1.0, whole)):
        expected = Rotation.from_euler("zy", [share * twist, share * tilt]).apply(np.vstack([across, 0 * across[:1]]).T)
        np.testing.assert_allclose(moved.T - moved.mean(1), expected, atol=1e-12)
    change = motion.imposed(np.zeros(space.unknowns), 0.51) - motion.imposed(np.zeros(space.unknowns), 0.49)
    np.testing.assert_allclose(motion.rate(0.5), change / 0.02, atol=1e-3)
