"""Members of a case: the same case with cells that are a little off."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.errors import CaseError
from ngcell.scene import MemberChoice, check_has_members, member_of, read_case

CASE = read_case("shear-empty-3x3")


class Grown:
    """A tissue of a script."""


def walls(spread: float, count: int = 400) -> np.ndarray:
    return np.array([member_of(CASE, seed, spread).tissue.wall for seed in range(count)])


def test_a_seed_gives_the_same_member_again_and_another_seed_another() -> None:
    assert member_of(CASE, 3, 1e-3) == member_of(CASE, 3, 1e-3)
    assert len(set(walls(1e-3, 20))) == 20


def test_walls_spread_by_the_share_that_is_asked_for() -> None:
    change = walls(0.01) / CASE.tissue.wall - 1
    assert change.std() == pytest.approx(0.01, rel=0.1)
    assert abs(change.mean()) < 3 * 0.01 / 20


def test_nothing_but_geometry_and_expected_numbers_differs() -> None:
    member = member_of(CASE, 3, 1e-3)
    assert CASE.expected and not member.expected
    assert member.model_copy(update={"tissue": CASE.tissue, "expected": CASE.expected}) == CASE


def test_user_defined_bodies_have_no_members() -> None:
    with pytest.raises(CaseError, match="user-defined bodies") as complaint:
        check_has_members(read_case("press-fit"))
    assert "\n" not in str(complaint.value)


def test_a_tissue_of_a_script_that_cannot_be_varied_is_named() -> None:
    with pytest.raises(CaseError, match="'Grown' cannot be varied"):
        check_has_members(CASE.model_copy(update={"tissue": Grown()}))


def test_a_member_that_is_no_tissue_is_refused_with_its_seed() -> None:
    thick = CASE.model_copy(update={"tissue": CASE.tissue.model_copy(update={"wall": 0.8660})})
    refused = 0
    for seed in range(10):
        try:
            member_of(thick, seed, 0.1)
        except CaseError as complaint:
            refused += 1
            assert f"member of seed {seed}: tissue.wall: a wall this thick closes the lumen" in str(complaint)
    assert 0 < refused < 10


@pytest.mark.parametrize(
    ("choice", "complaint"),
    [
        ({"count": 1}, "count = 1"),
        ({"count": 2.5}, "count = 2.5"),
        ({"seed": -1}, "seed = -1"),
        ({"spread": 0.0}, "spread = 0.0"),
        ({"spread": 0.2}, "spread = 0.2"),
    ],
)
def test_a_choice_out_of_range_is_refused(choice: dict, complaint: str) -> None:
    with pytest.raises(CaseError, match=complaint):
        MemberChoice(**choice)
