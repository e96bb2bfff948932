"""Ends of prisms under a pressure: a closed form, the theorem of Betti, and the balance of energy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from ngcell.build.simulation import Simulation
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Role
from tests.prisms import case, last_step

C1, C2, KAPPA = 1.0, 1.0, 100.0
STILL = {"kind": "plates", "displacement": (0.0, 0.0), "levels": 1}
ONE = {"rows": 1, "cols": 1, "wall": 0.2, "height": 0.5}
MESH = {"order": 2, "size": 1.0, "slices": 1}


def nominal_stress(along: float, across: float) -> tuple[float, float]:
    """Nominal stress of the solid along the axis and across it at the stretches (across, across, along)."""
    stretch = np.array([across, across, along])
    first, jacobian = (stretch**2).sum(), stretch.prod()
    second = (first**2 - (stretch**4).sum()) / 2
    one = jacobian ** (-2 / 3) * (stretch - first / (3 * stretch))
    two = jacobian ** (-4 / 3) * (stretch * (first - stretch**2) - 2 * second / (3 * stretch))
    stress = C1 * one + C2 * two + KAPPA * np.log(jacobian) / stretch
    return stress[2], stress[0]


@pytest.mark.parametrize("along", [0.8, 1.3])
@pytest.mark.parametrize("layers", [1, 2])
def test_a_cell_between_pressed_ends_is_in_balance_at_the_stretch_of_the_closed_form(along, layers):
    """Hollow cells with free sides are in uniaxial stress; the pressure is per reference area."""
    across = brentq(lambda width: nominal_stress(along, width)[1], 0.5, 2.0, xtol=1e-15, rtol=1e-14)
    pressure = -nominal_stress(along, across)[0]
    scene = case(0.5, tissue=ONE | {"layers": layers}, mesh=MESH)
    load = scene.load.model_copy(update={"ends": "pressed", "end_pressure": pressure})
    simulation = Simulation(scene)
    space = simulation.space
    applied = AppliedLoads(space, load.tractions(), PrescribedMotion(space, []))
    applied.apply(1.0)
    at = space.affine(np.diag([across, across, along]) - np.eye(3), np.zeros(3)).ravel()
    force = applied.gradient(space.configuration(at))
    if layers == 1:
        rest = simulation.problem.force(space.configuration(at), Role.INTERNAL) + force
        np.testing.assert_allclose(rest, 0, atol=1e-10 * np.abs(force).max())
    ring = 1.5 * np.sqrt(3) * (1 - (1 - 0.2 / (np.sqrt(3) / 2)) ** 2)
    by_height = force.reshape(3, -1)[2] * space.one
    top = layers * 0.5
    assert by_height[space.rest[2] == top].sum() == pytest.approx(pressure * ring, rel=1e-12)
    assert by_height[space.rest[2] == 0].sum() == pytest.approx(-pressure * ring, rel=1e-12)
    assert by_height[(space.rest[2] > 0) & (space.rest[2] < top)] == pytest.approx(0, abs=1e-15)


def test_pressed_ends_and_moved_plates_obey_the_theorem_of_betti():
    """Small loads: the force that pressed ends put on a plate, times how far the plate moves, is the work that the
    pressure does on the ends as the plate moves."""
    small = 1e-6
    pressed = last_step(case(0.5, tissue=ONE, mesh=MESH, load=STILL | {"ends": "pressed", "end_pressure": small}))
    scene = case(0.5, tissue=ONE, mesh=MESH, load=STILL | {"displacement": (0.0, small)})
    simulation = Simulation(scene)
    moved = list(simulation.accepted_steps())[-1]
    assert pressed.record.certified
    assert moved.record.certified
    applied = AppliedLoads(
        simulation.space,
        scene.load.model_copy(update={"ends": "pressed", "end_pressure": small}).tractions(),
        simulation.motion,
    )
    applied.apply(1.0)
    work = -applied.potential(moved.displacement)
    assert work > 0
    assert pressed.record.plate_force_y * small == pytest.approx(-work, rel=1e-4)


def test_stored_energy_is_the_work_of_the_pressure():
    """Small loads store half of what they do at full strength, on layers that press on each other as well."""
    pressure, tissue = 1e-5, ONE | {"layers": 2}
    load = STILL | {"ends": "pressed", "end_pressure": pressure, "levels": 1}
    simulation = Simulation(case(0.5, tissue=tissue, mesh=MESH, load=load))
    step = list(simulation.accepted_steps())[-1]
    assert step.record.certified
    (loads,) = (term for term in simulation.problem.terms if isinstance(term, AppliedLoads))
    potential = loads.potential(step.displacement, 1.0)
    assert potential < 0
    assert step.record.energy == pytest.approx(-potential / 2, rel=1e-3)
