"""Tissues of cells under pressure, or filled with a solid."""

from __future__ import annotations

from functools import cache
from math import inf
from typing import Any

import numpy as np
import pytest

from ngcell import Case, simulate
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.contact.surface.surface import SurfacePoints

WALL = {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0}
GEL = {"kind": "mooney-rivlin", "c1": 0.01, "c2": 0.0, "bulk_modulus": 10.0}


def tissue(rows: int, cols: int, **sections: Any) -> Case:
    cells = {"rows": rows, "cols": cols, "wall": 0.1}
    given = {"tissue": cells, "material": WALL, "mesh": {"order": 2}, "accuracy": inf}
    return Case.model_validate(given | sections)


def sheared(lumen: dict[str, Any] | None, strategy: str) -> Step:
    case = tissue(
        2,
        2,
        load={"kind": "plates", "displacement": [0.5, 0.0], "levels": 1},
        strategy={"kind": strategy},
        **({"lumen": lumen} if lumen else {}),
    )
    return simulate(case)[-1]


@cache
def hollow() -> Step:
    return sheared(None, "single-step")


@pytest.mark.parametrize(("rows", "cols", "pressure"), [(1, 4, 0.5), (2, 2, 0.005)])
def test_pressure_in_confined_cells_of_any_wall_moves_nothing_and_comes_back_as_contact_pressure(rows, cols, pressure):
    """K5: incompressible walls, the outer boundary held; in a row of cells no three meet at a corner."""
    case = tissue(
        rows,
        cols,
        material=WALL | {"bulk_modulus": 2e4},
        lumen={"kind": "pressure", "pressure": pressure},
        load={"kind": "frame", "shear": 0.0, "levels": 1},
        contact={"kind": "mortar"},
        strategy={"kind": "single-step"},
        mesh={"order": 3},
    )
    simulation = Simulation(case)
    (step,) = simulation.accepted_steps()
    edge = np.unique(simulation.setup.facing.facet)
    places = np.linspace(0.01, 0.99, 7)
    points = SurfacePoints(np.repeat(edge, 7), np.tile(places, len(edge)), np.zeros(7 * len(edge)))
    found = simulation.contact.contact_pressures(simulation.problem.configuration(step.displacement), points)
    np.testing.assert_allclose(found, pressure, rtol=1e-3)
    assert np.abs(step.displacement).max() < 1e-3
    assert step.record.largest_gap < 1e-5
    assert step.measurement.certificate.passed


@pytest.mark.parametrize(
    "lumen",
    [
        {"kind": "pressure", "pressure": 0.005},
        {"kind": "inclusion", "material": GEL},
        {"kind": "fluid"},
    ],
    ids=lambda lumen: lumen["kind"],
)
def test_what_cells_hold_keeps_them_together_whichever_way_they_are_loaded(lumen):
    empty = hollow()
    steps = [sheared(lumen, strategy) for strategy in ("sddp", "single-step")]
    one, two = (step.record for step in steps)
    assert all(step.measurement.certificate.passed for step in steps)
    assert one.energy == pytest.approx(two.energy, rel=1e-6)
    assert one.plate_force_x == pytest.approx(two.plate_force_x, rel=1e-4)
    assert one.mean_gap < empty.record.mean_gap
    assert one.energy > empty.record.energy


def test_a_pressure_that_comes_first_is_there_in_full_at_every_level():
    load = {"kind": "plates", "displacement": [0.2, 0.0], "levels": [0.5, 1.0]}

    def energies(pressure: float, ramp: str) -> list[float]:
        lumen = {"kind": "pressure", "pressure": pressure, "ramp": ramp}
        steps = simulate(tissue(1, 2, lumen=lumen, load=load))
        assert all(step.measurement.certificate.passed for step in steps)
        return [step.record.energy for step in steps if step.record.phase == "released"]

    first, grown, twice = energies(0.004, "first"), energies(0.004, "with-load"), energies(0.008, "with-load")
    assert first == pytest.approx([twice[0], grown[1]], rel=1e-9)
    assert first[0] > grown[0]


def pressures(step: Step) -> np.ndarray:
    return np.array([row.pressure for row in step.cells])


def test_a_fluid_keeps_the_area_of_its_lumen_and_its_pressure_does_what_a_given_one_would():
    sections = {
        "load": {"kind": "plates", "displacement": [0.3, 0.0], "levels": 2},
        "contact": {"kind": "mortar"},
    }
    turgid = simulate(tissue(2, 2, lumen={"kind": "fluid", "fill": 1.02}, **sections))
    assert all(step.measurement.certificate.passed for step in turgid)
    checks = [check for step in turgid for check in step.measurement.certificate.checks]
    assert max(check.value for check in checks if check.name == "lumen_area") < 1e-10
    found = pressures(turgid[-1])
    assert found.min() > 0 and np.ptp(found) > 0.1 * found.max()
    cells = [step.snapshot.bulk.cell_data for step in turgid if step.snapshot]
    assert set(np.ravel(cells[-1]["cell_pressure"])) == set(found)
    given = simulate(tissue(2, 2, lumen={"kind": "pressure", "pressure": found.reshape(2, 2).tolist()}, **sections))
    one, two = turgid[-1].record, given[-1].record
    assert one.energy == pytest.approx(two.energy, rel=1e-7)
    assert one.plate_force_x == pytest.approx(two.plate_force_x, rel=1e-6)
    np.testing.assert_allclose(pressures(given[-1]), found, rtol=1e-12)
    np.testing.assert_allclose(pressures(given[1]), found / 2, rtol=1e-12)


def test_confined_turgid_cells_do_not_move_and_press_each_other_with_what_they_hold():
    """Outer walls held, cells filled beyond their rest: all hold the same pressure, and no wall opens."""
    (step,) = simulate(
        tissue(
            1,
            3,
            lumen={"kind": "fluid", "fill": 1.001, "ramp": "first"},
            load={"kind": "frame", "shear": 0.0, "levels": 1},
            strategy={"kind": "single-step"},
            contact={"kind": "mortar"},
        )
    )
    found = pressures(step)
    assert step.measurement.certificate.passed
    assert np.ptp(found) < 1e-3 * found.mean() and found.min() > 0.01
    assert step.record.largest_gap < 1e-3 * 0.1 and step.record.components == 1


def test_filled_cells_between_plates_come_to_the_same_rest_about_either_motion_and_sooner_about_a_steady_volume(
    monkeypatch,
):
    """The affine motion of a sheet would compress each filling by a tenth; what follows is long undone."""
    case = tissue(
        2,
        2,
        load={"kind": "plates", "stretch": 0.9, "levels": 1},
        lumen={"kind": "inclusion", "material": GEL},
        strategy={"kind": "single-step"},
    )
    steady = simulate(case)[-1]
    assert steady.record.certified and steady.record.plate_force_y < 0
    monkeypatch.setattr("ngcell.build.discretisation.keeps_volume", lambda lumen: False)
    affine = simulate(case)[-1]
    assert steady.record.energy == pytest.approx(affine.record.energy, rel=1e-9)
    assert steady.record.factorisations < 0.8 * affine.record.factorisations
