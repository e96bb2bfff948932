"""Contact is made stiffer where walls overlap by too much beside gaps that hardly open."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ngcell
from ngcell.build import mesh_level
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.terms import ContactTerm
from ngcell.results.growth import ONSET
from ngcell.results.record import StepRecord
from ngcell.solve.effort import OutOfIterations
from ngcell.solve.minimum import Minimum
from tests.tissues import small_tissue

WALL = 0.1
#: Four cells that a frame presses from all sides: their walls open at corners, by less than 1 % of their thickness. At
#: an accuracy of 0.1 firm contact ends on a coarser mesh than soft one, and their errors are not those of contact.
PRESSED = (
    "accuracy=0.05", "tissue.rows=2", "tissue.cols=2", "load={kind='frame', stretch=[0.95, 0.95], levels=1}",
)  # fmt: skip


def released() -> StepRecord:
    *_, step = ngcell.simulate(ngcell.read_case("shear-empty-3x3", PRESSED))
    return step.record


def test_where_walls_hardly_open_stiffer_contact_keeps_overlaps_from_ruling_the_error_of_the_gap(
    monkeypatch: pytest.MonkeyPatch,
):
    firm = released()
    monkeypatch.setattr(mesh_level.Level, "stiffer", lambda level, found: found)
    soft = released()
    assert firm.certified and firm.mean_gap < ONSET * WALL
    assert firm.mean_gap_error < soft.mean_gap_error / 1.3
    assert abs(firm.mean_gap - soft.mean_gap) < firm.mean_gap_error + soft.mean_gap_error
    assert abs(firm.energy - soft.energy) < firm.energy_error + soft.energy_error


def test_where_stiffer_contact_finds_no_equilibrium_it_stays_as_it_was(monkeypatch: pytest.MonkeyPatch):
    usual, raised = mesh_level.Level.stiffer, []

    def refused(*_: Any, **__: Any) -> Minimum:
        raise OutOfIterations

    def in_vain(level: Any, found: Any) -> Any:
        with monkeypatch.context() as patch:
            patch.setattr(mesh_level, "settled", refused)
            tried = usual(level, found)
        raised.extend(term.raised for term in found.problem.terms if isinstance(term, ContactTerm))
        assert tried.accepted.minimum is found.accepted.minimum
        return tried

    monkeypatch.setattr(mesh_level.Level, "stiffer", in_vain)
    step = released()
    assert raised and max(raised) == 1
    assert step.iterations > 0


def test_stiffer_terms_store_ten_times_as_much_until_they_find_no_way_down_at_corners():
    tissue = small_tissue(1, 2)
    mine = PenaltyContact(tissue.walls, tissue.contact.stiffness, 0.1)
    thickness = float(mine.walls.thickness.min())
    positions = tissue.positions(tissue.body_translation(1, np.array([-0.01 * thickness, 0.0])))
    before, found = mine.pair(positions).energy(positions), []
    while mine.stiffen():
        found.append(mine.pair(positions).energy(positions) / before)
    np.testing.assert_allclose(found, [10, 100])
    mine.restart()
    assert mine.stiffen() and mine.stiffen() and mine.raised == 100
    mine._factor *= 10  # as where it still turns out too soft
    mine.soften()
    assert mine.pair(positions).energy(positions) == pytest.approx(10 * before)


def test_contact_of_a_finer_mesh_is_no_softer_than_that_of_the_coarser_one():
    coarse, fine = small_tissue(1, 2), small_tissue(1, 2, order=3)
    theirs = PenaltyContact(coarse.walls, coarse.contact.stiffness, 0.1)
    mine = PenaltyContact(fine.walls, 4 * coarse.contact.stiffness.min() * np.ones(fine.walls.facet_count), 0.1)
    mine.stiffen_as(theirs)
    assert mine.raised == 1
    mine._derived *= 1 - 1e-15  # the same, but for round-off
    theirs._derived[:] = mine._derived[0] * (1 + 1e-15)
    mine.stiffen_as(theirs)
    assert mine.raised == 1
    theirs._factor *= 100  # what turns out too soft there is judged anew here
    mine.stiffen_as(theirs)
    assert mine.raised == 1
    theirs.restart()
    theirs.stiffen()
    mine.stiffen_as(theirs)
    np.testing.assert_allclose(mine.stiffness, theirs.stiffness.min())
