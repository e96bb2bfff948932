"""Mean and spread of the numbers of members, and what is said of them."""

from __future__ import annotations

from dataclasses import replace
from math import isnan, nan

import pytest

from ngcell.results.record import StepRecord
from ngcell.results.spread import Member, Spread, at_levels, spreads
from tests.cli.conftest import accepted_step


def member(number: int, *records: StepRecord | None) -> Member:
    return Member(number, number, "", all(record is not None and record.certified for record in records), records)


def with_energies(*energies: float, error: float = nan, certified: tuple[bool, ...] = ()) -> list[Member]:
    """Members of one level that differ in their energies."""
    verdicts = certified or (True,) * len(energies)
    step = accepted_step(0, 1.0)
    return [
        member(number, replace(step, energy=energy, energy_error=error, certified=verdict))
        for number, (energy, verdict) in enumerate(zip(energies, verdicts, strict=True))
    ]


def of(found: list[Spread], name: str) -> Spread:
    (row,) = (row for row in found if row.number == name)
    return row


def test_mean_and_deviation_are_those_of_a_sample() -> None:
    row = of(spreads(with_energies(1.0, 2.0, 3.0, error=0.5), [1.0], 1e-3, 1.0), "energy")
    assert (row.members, row.mean, row.deviation, row.smallest, row.largest) == (3, 2.0, 1.0, 1.0, 3.0)
    assert (row.error, row.relative, row.known_to) == (0.5, 0.5, 0.5)


def test_members_that_are_not_certified_do_not_count() -> None:
    members = [*with_energies(1.0, 2.0, 700.0, certified=(True, True, False)), member(3, None)]
    row = of(spreads(members, [1.0], 1e-3, 1.0), "energy")
    assert (row.members, row.mean, row.largest) == (2, 1.5, 2.0)
    assert spreads(members[2:], [1.0], 1e-3, 1.0) == []


def test_one_member_has_no_spread() -> None:
    row = of(spreads(with_energies(2.0), [1.0], 1e-3, 1.0), "energy")
    assert row.mean == 2.0 and isnan(row.deviation) and row.remark == ""


@pytest.mark.parametrize(
    ("scatter", "error", "share", "remark"),
    [
        (0.01, 0.005, 1e-3, ""),  # within three errors
        (0.01, 0.001, 1e-3, "neighbouring geometries end on other branches"),  # ten times the change of the geometry
        (0.01, 0.001, 1e-2, "it follows the geometry"),
        (0.01, nan, 1e-3, ""),  # nobody knows what the mesh explains
    ],
)
def test_what_neither_mesh_nor_geometry_explains_is_a_fork(
    scatter: float, error: float, share: float, remark: str
) -> None:
    row = of(spreads(with_energies(1 - scatter, 1.0, 1 + scatter, error=error), [1.0], share, 1.0), "energy")
    assert row.deviation == pytest.approx(scatter)
    assert row.remark == remark
    assert row.known_to == pytest.approx(max(scatter, 0 if isnan(error) else error))


def test_a_part_of_the_force_that_vanishes_is_judged_by_the_whole_force() -> None:
    step = replace(accepted_step(0, 1.0), plate_force_x=1.0, plate_force_error=1e-4)
    members = [member(number, replace(step, plate_force_y=y)) for number, y in enumerate((-1e-3, 1e-3))]
    row = of(spreads(members, [1.0], 1e-3, 1.0), "plate_force_y")
    assert row.mean == 0 and isnan(row.known_to) and row.remark == "it follows the geometry"


@pytest.mark.parametrize(
    ("side", "remark"), [(0.1, "neighbouring geometries end on other branches"), (2.0, "it follows the geometry")]
)
def test_gaps_follow_the_places_of_corners(side: float, remark: str) -> None:
    step = replace(accepted_step(0, 1.0), mean_gap_error=1e-6)
    members = [member(number, replace(step, mean_gap=gap)) for number, gap in enumerate((0.0999, 0.1, 0.1011))]
    row = of(spreads(members, [1.0], 1e-3, side), "mean_gap")
    assert 2.7e-4 < row.deviation < 1e-3
    assert row.remark == remark


def test_levels_are_found_in_the_order_of_the_load_path() -> None:
    path = [accepted_step(step, factor) for step, factor in enumerate((0.5, 1.0, 0.75, 0.5))]
    tied = replace(accepted_step(9, 1.0), phase="tied")
    assert [record and record.step for record in at_levels([tied, *path], (1.0, 0.5, 1.0))] == [1, 3, None]


def test_size_of_the_force_is_of_the_vector() -> None:
    step = replace(accepted_step(0, 1.0), plate_force_x=3.0, plate_force_y=4.0)
    assert of(spreads([member(0, step)], [1.0], 1e-3, 1.0), "plate_force").mean == 5.0
