"""Some forty scenes far outside comfort: each ends certified and right, or says that not; see `tools.extreme`."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import pytest

import ngcell
from ngcell.errors import NotConverged
from ngcell.run import Step
from ngcell.scene.kinds import kind_of_case
from tools.extreme.points import QUICK, points

POINTS = {point.label: point for point in points() if point.is_quick}
SOLVABLE = [label for label, point in POINTS.items() if point.has_solution]
#: Changes by which a point ends the same way in less time: far more pressure, which is given up sooner; one level up to
#: the same load in place of two; a pair of cells in place of four; a coarser mesh.
SOONER: dict[str, dict[str, Any]] = {
    "cell pressure: a pair of cells 2": {"lumen": {"kind": "pressure", "pressure": 5.0}},
    "shear: 1 frame, penalty": {"load": {"kind": "frame", "shear": 1.0, "levels": 1}},
    "compression: 0.75 frame, penalty": {"load": {"kind": "frame", "stretch": [1.0, 0.75], "levels": 1}},
    "compression: 0.9 plates, penalty": {"load": {"kind": "plates", "stretch": 0.9, "levels": 1}},
    "inclusion / wall: 1e-04, penalty": {"tissue": {"rows": 1, "cols": 2, "wall": 0.1}},
    "inclusion / wall: 1e+04, penalty": {"tissue": {"rows": 1, "cols": 2, "wall": 0.1}},
    "prisms: bulk / shear 1e+04": {"mesh": {"order": 2, "size": 1.0, "slices": 1}},
}


@lru_cache(maxsize=8)  # those that are compared are neighbours
def steps_of(label: str) -> list[Step]:
    table = POINTS[label].case | SOONER.get(label, {})
    return ngcell.simulate(kind_of_case(table).model_validate(table))


def energy_of(label: str) -> float:
    """Energy at the last level, in units of stress and length**2 of the plain scene."""
    length, stress = POINTS[label].units
    return steps_of(label)[-1].record.energy / (stress * length**2)


@pytest.mark.parametrize("label", SOLVABLE)
def test_it_is_right_and_certified(label):
    steps = steps_of(label)
    assert [step.measurement.certificate.failures for step in steps] == [()] * len(steps)
    assert [finding.quantity for step in steps for finding in step.findings if not finding.passed] == []
    assert all(math.isfinite(step.record.energy) for step in steps)
    point = POINTS[label]
    if point.same_as:
        assert energy_of(label) == pytest.approx(energy_of(f"{point.group}: {point.same_as}"), rel=1e-8)


@pytest.mark.parametrize("label", [label for label in POINTS if label not in SOLVABLE])
def test_where_there_is_no_equilibrium_none_is_certified(label):
    try:
        steps = steps_of(label)
    except NotConverged as failure:
        assert failure.outcome in {"RELEASE_FAILED", "TIED_FAILED", "OUT_OF_ITERATIONS"}
    else:
        assert not all(step.record.certified for step in steps)


def test_there_are_some_of_all_kinds():
    assert SOONER.keys() <= POINTS.keys()
    assert len(POINTS) == len(QUICK) == 37
    assert {point.group for point in POINTS.values()} == {point.group for point in points()}
