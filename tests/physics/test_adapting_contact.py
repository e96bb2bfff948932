"""Bonded cells whose walls bend so much that they would sink in between the points of contact, step by step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ngcell import Case
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from tests.prisms import MATERIAL

#: A noisy honeycomb of four cells, pressed by a tenth.
PRESSED = Case.model_validate(
    {
        "title": "pressed",
        "tissue": {"kind": "perturbed", "rows": 2, "cols": 2, "spread": 0.03, "seed": 1, "wall": 0.1},
        "material": MATERIAL,
        "load": {"kind": "plates", "stretch": 0.9, "levels": 1},
        "cohesion": {"strength": 0.05, "energy": 0.0015},
        "strategy": {"kind": "load-stepping"},
        "mesh": {"order": 2},
    }
)
REFINED = "penalty_is_refined"


@pytest.fixture(scope="module")
def pressed() -> list[Step]:
    return list(Simulation(PRESSED).accepted_steps())


def worst(steps: list[Step], name: str) -> float:
    return max(check.value for step in steps for check in step.report.certificate.checks if check.name == name)


def test_the_rule_of_contact_is_made_finer_before_overlaps_between_its_points_are_too_deep(pressed):
    """Without that they are 1.6 % of the wall deep."""
    refined = [bool(step.checkpoint.memory[REFINED].any()) for step in pressed]
    assert not refined[0] and refined[-1] and sorted(refined) == refined
    assert worst(pressed, "penetration_over_wall") < 0.0125


def test_energy_is_accounted_for_where_contact_adapts(pressed):
    """Work of the plates is what is stored, spent on bonds and lost."""
    last = pressed[-1].record
    assert last.load_factor == 1
    assert worst(pressed, "energy_balance") <= 1e-3
    displacement = np.array([step.record.plate_displacement for step in pressed])
    force = np.array([np.hypot(step.record.plate_force_x, step.record.plate_force_y) for step in pressed])
    work = float(np.trapezoid(np.append(0.0, force), np.append(0.0, displacement)))
    spent = last.energy + last.separation_energy + last.dissipation
    assert work == pytest.approx(spent, rel=5e-3)


def test_a_path_that_goes_on_from_a_checkpoint_takes_the_contact_that_it_had(pressed):
    number = next(number for number, step in enumerate(pressed) if step.checkpoint.memory[REFINED].any())
    resumed = next(Simulation(PRESSED).accepted_steps(replace(pressed[number].checkpoint)))
    assert resumed.record.load_factor == pressed[number + 1].record.load_factor
    assert resumed.record.energy == pytest.approx(pressed[number + 1].record.energy, rel=1e-9)
    np.testing.assert_array_equal(resumed.checkpoint.memory[REFINED], pressed[number + 1].checkpoint.memory[REFINED])
