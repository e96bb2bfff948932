"""Some forty scenes far outside comfort: each ends certified and right, or says that not; see `tools.extreme`."""

from __future__ import annotations

import math

import pytest

import ngcell
from ngcell.errors import NotConverged
from ngcell.scene.kinds import kind_of_case
from tools.extreme.points import QUICK, points

POINTS = {point.label: point for point in points() if point.is_quick}
SOLVABLE = [label for label, point in POINTS.items() if point.has_solution]


def steps_of(label: str) -> list:
    table = POINTS[label].case
    return ngcell.simulate(kind_of_case(table).model_validate(table))


#: Energies found, in units of stress and length**2 of the plain scene.
ENERGY: dict[str, float] = {}


@pytest.mark.parametrize("label", SOLVABLE)
def test_it_is_certified_and_right(label):
    steps = steps_of(label)
    assert all(step.record.certified for step in steps), [step.measurement.certificate.failures for step in steps]
    assert [finding.quantity for step in steps for finding in step.findings if not finding.passed] == []
    assert all(math.isfinite(step.record.energy) for step in steps)
    point, (length, stress) = POINTS[label], POINTS[label].units
    ENERGY[label] = steps[-1].record.energy / (stress * length**2)
    if point.same_as:
        assert ENERGY[label] == pytest.approx(ENERGY[f"{point.group}: {point.same_as}"], rel=1e-8)


@pytest.mark.parametrize("label", [label for label in POINTS if label not in SOLVABLE])
def test_where_there_is_no_equilibrium_none_is_certified(label):
    try:
        steps = steps_of(label)
    except NotConverged as failure:
        assert failure.outcome in {"RELEASE_FAILED", "TIED_FAILED"}
    else:
        assert not all(step.record.certified for step in steps)


def test_there_are_some_of_all_kinds():
    assert len(POINTS) == len(QUICK) == 48
    assert {point.group for point in POINTS.values()} == {point.group for point in points()}
