"""Estimated errors: exact where numbers converge as they are taken to, and never told where they are not known."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isnan

import numpy as np
import pytest

from ngcell.results.error import OF_ENERGY, SURE, Errors, Numbers, errors_beside, estimate
from ngcell.results.gaps_of_pairs import GapsOfPairs
from ngcell.results.parts_of_error import MOST_REMAINS, Refining, error_in_parts


def numbers(energy: float, force: float = 1.0, gap: float = 1.0, besides: float = 0.0, overlap: float = 0.0) -> Numbers:
    return Numbers(energy, energy, np.array([force, 0.0]), 1.0, gap, gap, (1e-9, 1e-9, 1e-2), besides, overlap)


def by_order(remains: float) -> list[Refining]:
    """Refinements by an order each."""
    return [Refining(remains)] * 5


def test_one_mesh_tells_nothing():
    errors = estimate([numbers(1.0)], by_order(0.5))
    assert isnan(errors.energy) and errors.check(0.1).value == inf and not errors.check(0.1).passed


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
def test_a_geometric_sequence_is_told_exactly(share: float):
    found = [numbers(2.0 + share**step) for step in range(3)]
    assert estimate(found, by_order(0.01)).energy == pytest.approx(share**2, rel=1e-12)
    assert estimate(found, by_order(0.01), of_last=False).energy == pytest.approx(share, rel=1e-12)


def test_one_refinement_leaves_no_less_than_the_strongest_singularity():
    at_corner = Refining(0.4, elsewhere=0.6, remains_of_gaps=0.3).unmeasured
    assert (at_corner.remains, at_corner.of_gaps.remains) == (0.6, 0.6)
    found = [numbers(1.4), numbers(1.0)]
    assert estimate(found, [at_corner], of_last=False).energy == pytest.approx(1.0, rel=1e-12)


def test_a_singularity_lets_remain_what_no_measured_share_may_belittle():
    # The coarsest mesh is far off for another reason: the second refinement changes a hundredth of the first.
    found = [numbers(11.0), numbers(1.0 + 0.1), numbers(1.0)]
    assert estimate(found, by_order(0.5)).energy == pytest.approx(0.1, rel=1e-12)
    assert estimate(found, by_order(0.001)).energy < 0.01


def test_what_does_not_converge_is_told_to_be_far_off():
    found = [numbers(1.0), numbers(1.1), numbers(1.3)]
    assert estimate(found, by_order(0.1)).energy == pytest.approx(0.2 * MOST_REMAINS / (1 - MOST_REMAINS), rel=1e-12)


def test_the_largest_relative_error_is_judged():
    found = [numbers(1.0, 1.0, 2.0), numbers(1.01, 1.1, 2.0)]
    errors = estimate(found, by_order(0.5))
    assert errors.relative == pytest.approx(0.1 / 1.1, rel=1e-12)
    assert errors.check(0.1).passed and not errors.check(0.09).passed


def test_soft_contact_and_what_floats_add_to_the_error_of_the_energy():
    found = [numbers(1.0, besides=0.1), numbers(1.0, besides=0.02)]
    assert estimate(found, by_order(0.5)).energy == pytest.approx(0.02, rel=1e-12)


def test_errors_without_estimate_fail_the_check():
    assert not Errors().check(inf).value < inf


def test_grading_leaves_the_errors_of_corners_that_are_not_graded():
    """Half of the error is of corners that grading reaches, where it leaves a tenth, and half of others."""
    reached, others = (0.5, 0.25, 0.025, 0.0125), (0.5, 0.25, 0.25, 0.125)
    found = [numbers(2.0 + one + other) for one, other in zip(reached, others, strict=True)]
    refined = [Refining(0.5), Refining(0.1, is_graded=True), Refining(0.5)]
    assert estimate(found[:2], refined).energy == pytest.approx(0.5, rel=1e-12)
    assert estimate([numbers(4.0), *found], [Refining(0.5), *refined]).energy == pytest.approx(0.1375, rel=1e-12)
    graded = estimate([numbers(4.0), *found[:3]], [Refining(0.5), *refined[:2]]).energy
    assert graded == pytest.approx(0.275, rel=1e-12)  # a tenth of the change over nine tenths would be 0.025


def test_a_number_that_stays_by_accident_is_told_what_the_share_has_left():
    found = [numbers(2.0 + 0.5**step, gap=gap) for step, gap in enumerate((1.0, 1.3, 1.1, 1.1))]
    assert estimate(found[:3], by_order(0.5)).mean_gap == pytest.approx(0.2, rel=1e-12)
    assert estimate(found, by_order(0.5)).mean_gap == pytest.approx(0.1, rel=1e-12)


def test_what_stays_twice_is_no_accident():
    """From the third mesh on the walls carry no plate force, which was told to be known to a fifth."""
    found = [numbers(2.0 + 0.5**step, force=force) for step, force in enumerate((1.0, 0.2, 0.0, 0.0, 0.0))]
    assert estimate(found[:3], by_order(0.5)).plate_force == pytest.approx(0.2, rel=1e-12)
    assert estimate(found[:4], by_order(0.5)).plate_force == pytest.approx(0.1, rel=1e-12)
    assert estimate(found, by_order(0.5)).plate_force == 0


def test_where_walls_are_hardly_strained_forces_err_by_no_more_than_they_are():
    """A tissue has come apart on the second mesh; the first one still pressed it a little."""
    found = [numbers(2.0), numbers(1e-10, force=1e-8, gap=2.0), numbers(1e-13, force=1e-11, gap=2.2)]
    errors = estimate(found, by_order(0.5))
    assert (errors.energy, errors.plate_force) == pytest.approx((1e-13, 1e-11), rel=1e-9)
    assert errors.mean_gap == pytest.approx(0.2, rel=1e-9)  # gaps are as far off as ever
    assert errors.relative == pytest.approx(0.2 / 2.2, rel=1e-9)
    assert estimate(found, by_order(0.5), of_last=False).plate_force == pytest.approx(1e-8, rel=1e-9)
    strained = [found[0], numbers(1e-8, force=1e-8, gap=2.0), found[2]]
    assert estimate(strained, by_order(0.5)).plate_force == pytest.approx(1e-8, rel=2e-3)


def test_what_is_nothing_twice_is_judged_by_gaps_alone():
    """Half of the force that counts as nothing, 1e-9, is left where walls have come apart."""
    strained, nothing, last = numbers(1e-8, force=0.0), numbers(1e-10, force=0.0), numbers(1e-13, force=5e-10)
    assert estimate([numbers(2.0), nothing, last], by_order(0.5)).relative < 1e-3
    assert estimate([numbers(2.0), strained, last], by_order(0.5)).relative > 0.1


@pytest.mark.parametrize(("moves", "left"), [(0.0, 0.1), (0.02, 0.08), (0.09, 0.09 / 3)])
def test_a_grade_alone_leaves_of_gaps_what_it_has_not_changed(moves: float, left: float):
    """Of the energy it has found three quarters; gaps depend on walls between the corners that it is towards."""
    found = [numbers(9.0, gap=3.0), numbers(2.2, gap=1.1), numbers(2.1, gap=1.0), numbers(2.025, gap=1.0 - moves)]
    refined = [Refining(0.5), Refining(0.5), Refining(0.1, is_graded=True, elsewhere=1.0)]
    errors = estimate(found, refined)
    assert (errors.energy, errors.mean_gap) == pytest.approx((0.025, left), rel=1e-9)
    assert errors.largest_gap == errors.mean_gap


def test_gaps_are_told_by_a_share_of_their_own():
    found = [numbers(9.0, gap=2.0), numbers(2.1, gap=1.1), numbers(2.05, gap=1.0)]
    errors = estimate(found, [Refining(0.5), Refining(0.6, remains_of_gaps=0.5)])
    assert (errors.energy, errors.mean_gap) == pytest.approx((0.075, 0.1), rel=1e-12)


def test_what_is_told_by_the_mesh_of_the_load_path_is_not_remembered():
    found = [numbers(9.0), numbers(2.1), numbers(2.05)]
    assert estimate(found, by_order(0.5)).energy == pytest.approx(0.05, rel=1e-12)


def test_soft_contact_adds_to_forces_by_its_share_of_the_energy_and_to_gaps_by_the_overlap():
    found = [numbers(2.0), numbers(2.0, force=3.0, besides=0.02, overlap=1e-3)]
    still = estimate([numbers(2.0, force=3.0), found[1]], by_order(0.5))
    assert (still.plate_force, still.contact_force) == pytest.approx((0.03, 0.01), rel=1e-12)
    assert (still.mean_gap, still.largest_gap) == pytest.approx((1e-3, 1e-3), rel=1e-12)


def test_a_mean_gap_that_stays_is_told_a_share_of_the_error_of_the_energy():
    still = estimate([numbers(2.2, gap=0.5), numbers(2.0, gap=0.5)], by_order(0.5))
    assert still.mean_gap / 0.5 == pytest.approx(OF_ENERGY * 0.2 / 2.0, rel=1e-12)
    assert still.relative == pytest.approx(0.1, rel=1e-12)  # that of the energy
    moved = estimate([numbers(2.2, gap=0.6), numbers(2.0, gap=0.5)], by_order(0.5))
    assert moved.mean_gap == pytest.approx(0.1, rel=1e-12)


def test_a_mean_gap_below_zero_errs_by_no_less_than_itself():
    """Bodies do not overlap: the true one is not below zero."""
    found = [numbers(2.0, gap=-1e-3), numbers(2.0, gap=-1e-3, overlap=1e-4)]
    assert estimate(found, by_order(0.5)).mean_gap == pytest.approx(1e-3, rel=1e-12)


def test_a_mean_gap_that_vanishes_is_judged_by_what_counts_as_opened():
    found = [numbers(2.0, gap=2e-4), numbers(2.0, gap=1e-4)]
    errors = estimate(found, by_order(0.5))
    assert errors.mean_gap == pytest.approx(1e-4, rel=1e-12)
    assert errors.relative == pytest.approx(1e-2, rel=1e-12)


#: Refinements by an order, by a grade alone, by an order, and by both: what they leave of corners and elsewhere.
IN_PARTS = [Refining(0.5), Refining(0.5, elsewhere=0.6), Refining(0.1, True, 1.0), Refining(0.6, False, 0.5)]
IN_PARTS += [Refining(0.07, True, 0.5)]


def in_parts(corners: float, others: float) -> list[float]:
    """Return the errors of the meshes, those of corners and others on the second mesh given."""
    of_corners = corners * np.cumprod([1.0, *(how.remains for how in IN_PARTS[1:])])
    of_others = others * np.cumprod([1.0, *(how.elsewhere for how in IN_PARTS[1:])])
    return list(of_corners + of_others)


def test_an_error_of_two_parts_is_told_exactly_once_a_grade_has_told_them_apart():
    """By shares alone, with what coarse meshes were told, it would be told twice as large."""
    errors = in_parts(1.0, 0.5)
    found = [numbers(9.0), *(numbers(3.0 + error) for error in errors)]
    assert estimate(found, IN_PARTS).energy == pytest.approx(errors[-1], rel=1e-12)
    assert error_in_parts([1.0, 0.5, 0.2], IN_PARTS) is None  # the grade itself is told by the order before


@pytest.mark.parametrize("strength", [0.52, 0.6, 0.75, 1.0])
def test_what_a_grade_and_an_order_leave_together_hardly_depends_on_the_singularity_that_is_assumed(strength: float):
    """Changes of a sheared tissue of polygons: 6.8e-6 by a grade, then 1.2e-6 by an order, then 1.0e-6 by both."""
    at_corners = [0.2 ** (2 * strength), 0.8 ** (4 * strength), (5 / 6) ** (4 * strength) * 0.2 ** (2 * strength)]
    shares = zip(at_corners, [True, False, True], [1.0, 0.8**2, (5 / 6) ** 2], strict=True)
    left = error_in_parts([6.8e-6, 1.2e-6, 1.0e-6], [Refining(*share) for share in shares])
    assert left is not None and 0.8e-6 < left < 2.5e-6


def test_a_number_is_told_the_largest_change_of_any_mesh_beside_that_of_the_potential():
    """The gap jumps once, as much as the potential changes there, and then stays."""
    errors = in_parts(1.0, 0.5)
    gaps = [5.0, 2.0, 2.0, 2.0, 2.0 + errors[2] - errors[3], 2.0 + errors[2] - errors[3]]
    found = [numbers(energy, gap=gap) for energy, gap in zip([9.0, *(3.0 + e for e in errors)], gaps, strict=True)]
    assert estimate(found, IN_PARTS).mean_gap == pytest.approx(errors[4], rel=1e-12)


def test_gaps_are_compared_over_the_walls_that_are_held_on_the_last_mesh():
    """A third body rattles: on one mesh something holds it, on the next nothing does."""
    bodies, length = np.array([[0, 1], [1, 2]]), np.ones(2)

    def with_gaps(first: float, second: float, is_held: bool) -> Numbers:
        integral = np.array([first, second])
        facet = np.array([[0, 0], [1, 1]])
        gaps = GapsOfPairs(bodies, np.array([True, is_held]), length, integral, integral, facet, integral)
        mean, largest = gaps.mean_and_largest(gaps.is_held)
        return replace(numbers(2.0), mean_gap=mean, largest_gap=largest, gaps=gaps)

    one, two = with_gaps(1.0, 9.0, True), with_gaps(1.1, 3.0, False)
    assert estimate([one, two], by_order(0.5)).mean_gap == pytest.approx(0.1, rel=1e-12)
    assert estimate([two, one], by_order(0.5)).mean_gap == pytest.approx(2.95, rel=1e-12)  # held: it counts


def test_a_state_beside_another_errs_by_what_lies_between_too():
    """As the minimum below a saddle that the meshes led to."""
    found = [numbers(1.0, 1.0, 2.0), numbers(1.01, 1.1, 2.02)]
    errors, below = estimate(found, by_order(0.5)), numbers(0.95, 1.0, 2.12)
    widened = errors_beside(errors, found[-1], below)
    assert widened.energy == pytest.approx(errors.energy + 0.06, rel=1e-12)
    assert widened.plate_force == pytest.approx(errors.plate_force + 0.1, rel=1e-12)
    assert widened.mean_gap == pytest.approx(errors.mean_gap + 0.1, rel=1e-12)
    assert widened.relative == pytest.approx(widened.plate_force / 1.0, rel=1e-12)
    same = errors_beside(errors, found[-1], found[-1])
    assert same == errors
    assert isnan(errors_beside(Errors(), found[-1], below).relative)


def test_of_a_mesh_that_one_other_tells_the_stored_energy_errs_by_no_less_than_the_potential():
    """Between loads and supports its change may vanish."""
    found = [numbers(2.0), replace(numbers(1.9), energy=1.99)]
    assert estimate(found, by_order(0.5), of_last=False).energy == pytest.approx(0.2, rel=1e-12)
    assert estimate(found, by_order(0.5)).energy == pytest.approx(0.01, rel=1e-12)


def test_after_a_grade_alone_no_more_is_told_than_some_times_what_corners_and_other_elements_leave():
    found = [numbers(9.0), numbers(2.4), numbers(2.2), numbers(2.1)]
    orders, grade = [Refining(0.5), Refining(0.7, elsewhere=0.5)], Refining(0.1, is_graded=True, elsewhere=1.0)
    by_change, of_corners, of_others = 0.7 / 0.3 * 0.2 - 0.1, 0.1 / 0.9 * 0.1, 0.2
    assert estimate(found, [*orders, grade]).energy == pytest.approx(by_change, rel=1e-9)
    told = estimate(found, [*orders, replace(grade, unsplit=0.1)]).energy
    assert told == pytest.approx(SURE * (of_corners + 0.1 * of_others), rel=1e-9)
    assert estimate(found, [*orders, replace(grade, unsplit=1.0)]).energy == pytest.approx(by_change, rel=1e-9)


def test_of_a_mesh_that_one_other_tells_contact_and_what_is_held_are_its_own():
    """The finer mesh may have stiffer contact."""
    rigid = numbers(1.9, 1.1, 1.2)
    soft = replace(numbers(2.0, besides=0.05, overlap=0.02), pulled=0.03, stiffer=0.4)
    alone = estimate([soft.without_contact, rigid], by_order(0.5), of_last=False)
    errors = estimate([soft, rigid], by_order(0.5), of_last=False)
    assert errors.energy == pytest.approx(alone.energy + 0.05, rel=1e-12)
    assert errors.plate_force == pytest.approx(alone.plate_force + 0.05 / 2 * 1.0, rel=1e-12)
    assert errors.contact_force == pytest.approx(alone.contact_force + 0.4, rel=1e-12)
    assert errors.mean_gap == pytest.approx(alone.mean_gap + 0.02, rel=1e-12)
    assert estimate([rigid, soft], by_order(0.5), of_last=False).energy == pytest.approx(0.2, rel=1e-12)
