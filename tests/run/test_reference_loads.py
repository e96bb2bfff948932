"""Loads of the references, each a case entry: solids that deform homogeneously in closed form, work against energy, and
paths that return."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
import pytest

from ngcell import Case, CaseError, simulate
from ngcell.build.discretisation import discretise
from ngcell.build.simulation import Simulation
from ngcell.geometry.bodies import LEFT_SIDE, LOWER_PLATE, RIGHT_SIDE
from tools.references.radial import RadialSolid

MATERIAL = {"kind": "mooney-rivlin", "c1": 1.0, "c2": 0.5, "bulk_modulus": 20.0}
SOLID = RadialSolid(1.0, 0.5, 20.0)
BRICKS = {"kind": "brick", "rows": 2, "cols": 2, "aspect": 2.0, "wall": 0.1, "stagger": 0.0}
FILLED = {"kind": "inclusion", "material": MATERIAL}
WIDTH, HEIGHT = 4.0, 2.0
PRESSED = {"kind": "plates", "stretch": 0.9}


def case(load: dict[str, Any], **parts: Any) -> Case:
    """Return a case of four bricks, hollow unless it says otherwise."""
    given = {"tissue": BRICKS, "material": MATERIAL, "mesh": {"order": 2}, "accuracy": inf, **parts}
    return Case.model_validate({**given, "load": {"levels": 1, **load}})


def energy(x: float, y: float) -> float:
    """Stored energy of a unit of area with these stretches along x and y, in plane strain, from the law itself."""
    squares, jacobian = np.array([x * x, y * y, 1.0]), x * y
    first, second = squares.sum(), squares[0] * squares[1] + squares[1] + squares[0]
    shape = SOLID.c1 * (jacobian ** (-2 / 3) * first - 3) + SOLID.c2 * (jacobian ** (-4 / 3) * second - 3)
    return float((shape + SOLID.kappa * np.log(jacobian) ** 2) / 2)


def test_a_confined_solid_is_in_uniaxial_strain():
    """Released walls, which bear no shear in this state, give in by what their contact gives."""
    step, released = simulate(case({**PRESSED, "sides": "confined"}, lumen=FILLED))
    assert step.record.certified and released.record.certified
    assert released.record.energy == pytest.approx(step.record.energy, rel=0.01)
    assert step.record.energy == pytest.approx(WIDTH * HEIGHT * energy(1.0, 0.9), rel=1e-8)
    assert step.record.plate_force_y == pytest.approx(WIDTH * SOLID.slopes(1.0, 0.9)[1], rel=1e-8)
    built = discretise(case({**PRESSED, "sides": "confined"}, lumen=FILLED))
    left, right = (built.motion.resultant(step.measurement.reaction, side) for side in (LEFT_SIDE, RIGHT_SIDE))
    # Of a corner, the plate bears what is along y and the side what is along x.
    assert left[0] == pytest.approx(-HEIGHT * SOLID.slopes(1.0, 0.9)[0], rel=1e-8)
    assert right[0] == pytest.approx(-left[0], rel=1e-8)


@pytest.mark.parametrize(
    ("load", "stretches"),
    [
        ({"stretch": [1.1, 1.2]}, (1.1, 1.2)),
        ({"stretch": [1.25, 0.8]}, (1.25, 0.8)),
        ({"shear": 0.3}, (np.sqrt(1 + 0.15**2) + 0.15, np.sqrt(1 + 0.15**2) - 0.15)),
    ],
    ids=["biaxial", "pure shear", "simple shear"],
)
def test_a_frame_deforms_a_solid_homogeneously(load, stretches):
    """Two homogeneous states may be unstable where walls pull; tied, the solid has no choice."""
    tied = next(iter(Simulation(case({"kind": "frame", **load}, lumen=FILLED)).accepted_steps()))
    assert tied.record.phase == "tied"
    assert tied.record.energy == pytest.approx(WIDTH * HEIGHT * energy(*stretches), rel=1e-8)


@pytest.mark.parametrize(("orientation", "sides"), [("pointy", "free"), ("flat", "confined")])
def test_the_work_of_the_plate_is_the_energy(orientation, sides):
    tissue = {"rows": 2, "cols": 2, "wall": 0.1, "orientation": orientation}
    load = {"kind": "plates", "stretch": 0.99, "sides": sides, "levels": [0.98, 1.0, 0.99]}
    steps = [step for step in simulate(case(load, tissue=tissue)) if step.record.phase == "released"]
    before, full, middle = (step.record for step in steps)
    assert full.certified and middle.certified
    slope = (full.energy - before.energy) / 0.02
    way = full.plate_displacement
    assert slope == pytest.approx(-way * middle.plate_force_y, rel=1e-4)


def test_confined_walls_keep_their_place_along_x_and_slide():
    load = {"kind": "plates", "stretch": 0.95, "sides": "confined"}
    scene = case(load, tissue={"rows": 3, "cols": 2, "wall": 0.1, "orientation": "flat"})
    step, space = simulate(scene)[-1], discretise(scene).space
    assert step.record.certified
    at = step.displacement.reshape(2, -1)
    on_plate = space.region_unknowns(LOWER_PLATE)
    for side in (LEFT_SIDE, RIGHT_SIDE):
        unknowns = np.setdiff1d(space.region_unknowns(side), on_plate)
        assert np.abs(at[0, unknowns]).max() == 0
        assert np.abs(at[1, unknowns]).max() > 0.05


def test_a_plate_does_not_move_through_the_side_walls():
    with pytest.raises(CaseError, match=r"through the side walls; allowed: 0 along x, or free sides"):
        case({"kind": "plates", "displacement": [0.1, 0.0], "sides": "confined"})


def test_bonds_remember_the_way_there_and_hollow_cells_do_not():
    """Back at half of the load, spent bonds hold less than before, and what was lost is told; without bonds the way
    back is the way there."""
    path = {"kind": "plates", "displacement": [0.0, 0.06], "levels": [0.5, 1.0, 0.5]}
    bonded = {"cohesion": {"strength": 0.05, "energy": 0.0005}, "strategy": {"kind": "load-stepping"}}
    steps = (step.record for step in simulate(case(path, **bonded)))
    there, full, back = (step for step in steps if step.load_factor in (0.5, 1.0))
    assert there.certified and full.certified and back.certified
    assert full.bonded_share < there.bonded_share and back.bonded_share == full.bonded_share
    assert back.separation_energy == pytest.approx(full.separation_energy, rel=1e-6)
    assert abs(back.plate_force_y) < 0.9 * abs(there.plate_force_y)
