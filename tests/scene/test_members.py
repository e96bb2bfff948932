"""Members of a case: the same case with cells that are a little off."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from ngcell.errors import CaseError
from ngcell.scene import MemberChoice, check_has_members, geometry_share, member_of, read_case
from ngcell.scene.members import DEFAULT_SPREAD

CASE = read_case("shear-empty-3x3")


class Grown:
    """A tissue of a script."""


def test_a_seed_gives_the_same_member_again_and_another_seed_another() -> None:
    assert member_of(CASE, 3, 1e-3) == member_of(CASE, 3, 1e-3)
    corners = [member_of(CASE, seed, 1e-3).tissue.outlines.corners for seed in (3, 3, 4)]
    assert np.array_equal(corners[0], corners[1]) and not np.array_equal(corners[1], corners[2])


def test_corners_and_walls_differ_by_at_most_the_share_that_is_asked_for() -> None:
    tissue, regular = member_of(CASE, 0, 0.01).tissue, CASE.tissue
    moved = np.linalg.norm(tissue.outlines.corners - regular.outlines.corners, axis=1)
    assert 0.005 * regular.side < moved.max() <= 0.01 * regular.side
    change = np.abs(tissue.walls / regular.wall - 1)
    assert 0.005 < change.max() <= 0.01
    assert member_of(CASE, 0).tissue.spread == DEFAULT_SPREAD


def test_cells_that_are_drawn_from_a_seed_are_drawn_from_others() -> None:
    drawn = read_case("shear-empty-3x3", ["tissue.kind=perturbed", "tissue.spread=0.2", "tissue.wall_spread=0.3"])
    members = [member_of(drawn, seed).tissue for seed in (4, 5)]
    assert [member.seed for member in members] == [4, 5]
    assert all(member.model_copy(update={"seed": 0}) == drawn.tissue for member in members)
    with pytest.raises(CaseError, match="allowed: no spread for members, but one of the tissue"):
        check_has_members(drawn, 0.01)
    assert geometry_share(drawn, None) == (0.3, 1.0) and geometry_share(CASE, 0.01) == (0.01, 1.0)


def test_nothing_is_known_of_how_much_other_cells_that_are_drawn_differ() -> None:
    class Drawn(type(CASE.tissue)):
        kind: str = "drawn"
        seed: int = 0

    drawn = CASE.model_copy(update={"tissue": Drawn(rows=1, cols=2, wall=0.1)})
    assert member_of(drawn, 7).tissue.seed == 7
    assert geometry_share(drawn, None)[0] == inf


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
    thick = CASE.model_copy(update={"tissue": CASE.tissue.model_copy(update={"rows": 1, "cols": 2, "wall": 0.74})})
    refused = 0
    for seed in range(10):
        try:
            member_of(thick, seed, 0.1)
        except CaseError as complaint:
            refused += 1
            assert f"member of seed {seed}: tissue: cell " in str(complaint)
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
