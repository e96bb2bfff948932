"""The mortar method on the meshes of a scene: it acts where numbers are reported, and ends where accuracy is met."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import inf
from typing import Any

import numpy as np
import pytest

import ngcell
from ngcell.build import mesh_level, refinement
from ngcell.build.mesh_level import Level
from ngcell.build.meshed import Refined
from ngcell.build.options import Options
from ngcell.build.refinement import Refinement
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.terms import ContactTerm
from ngcell.problem.problem import Problem
from ngcell.results.error import Numbers
from ngcell.solve import handing_over
from ngcell.solve.continuation import Continuation
from ngcell.solve.handing_over import HandingOver
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum


def simulation(*sets: str) -> Simulation:
    usual = ["tissue.rows=2", "tissue.cols=2", "load.displacement=[0.4, 0.0]", "load.levels=1", "contact.kind=mortar"]
    return Simulation(ngcell.read_case("shear-empty-3x3", [*usual, *sets]))


def method(scene: Simulation) -> type:
    contact = scene.contact
    assert isinstance(contact, ContactTerm)
    return type(contact.method)


@cache
def solved(*sets: str) -> Step:
    *_, step = simulation(*sets).accepted_steps()
    return step


def test_where_the_path_is_not_reported_it_is_followed_by_a_penalty():
    scene = simulation()
    assert method(scene) is PenaltyContact
    assert method(scene.refinement.level(1)) is MortarContact


def test_meshes_that_are_not_reported_are_led_through_by_a_penalty(monkeypatch):
    seen: list[tuple[int, bool]] = []
    settled, finished = Level.settled, Level.finished

    def noted(level: Level, coarse: Refined, **how: bool) -> Refined | None:
        seen.append((coarse.level + 1, how["only_leads"] and coarse.accepted.phase == "released"))
        return settled(level, coarse, **how)

    monkeypatch.setattr(Level, "settled", noted)
    monkeypatch.setattr(
        Level, "finished", lambda level, led, **how: seen.append((led.level, False)) or finished(level, led, **how)
    )
    *_, step = simulation().accepted_steps()
    assert step.record.certified
    most = len(step.meshes) - 1
    assert most > 1
    assert seen[-most - 1 :] == [*((level, True) for level in range(1, most + 1)), (most, False)]


def test_where_walls_slip_on_a_fine_mesh_multipliers_take_over_on_a_coarser_one(monkeypatch):
    tried: list[tuple[int, bool]] = []
    usual, finished = solved().record, Level.finished

    def slipping(level: Level, led: Refined, *, may_slide: bool = True, **how: float) -> Refined | None:
        if led.accepted.phase == "tied":
            return finished(level, led)
        tried.append((led.level, may_slide))
        return finished(level, led, may_slide=may_slide, **how) if may_slide else None

    monkeypatch.setattr(Level, "finished", slipping)
    *_, step = simulation().accepted_steps()
    last = tried[0][0]
    assert last > 1
    assert tried == [(last, False), (1, True), (last, True)]
    assert step.record.certified
    assert step.record.energy == pytest.approx(usual.energy, rel=1e-9)  # nothing slips in fact
    assert step.record.iterations > usual.iterations


def test_where_the_error_hardly_falls_multipliers_take_over_on_a_coarser_mesh(monkeypatch):
    """Before a third mesh is made; last digits are not looked for there."""
    tried: list[tuple[int, bool]] = []
    usual, finished = solved().record, Level.finished

    def noted(level: Level, led: Refined, *, leads_below: float = -inf, **how: bool) -> Refined | None:
        if led.accepted.phase == "released":
            tried.append((led.level, leads_below == inf))
        return finished(level, led, leads_below=leads_below, **how)

    monkeypatch.setattr(refinement, "_SLOW", 0.0)
    monkeypatch.setattr(Level, "finished", noted)
    *_, step = simulation().accepted_steps()
    assert tried == [(1, True), (len(step.meshes) - 1, False)] and len(step.meshes) > 2
    assert step.record.certified
    assert step.record.energy == pytest.approx(usual.energy, rel=1e-6)  # nothing slips in fact


def test_the_penalty_leads_again_where_walls_slide_away(monkeypatch):
    """On the coarser mesh; it comes to the same rest if it has not gone anywhere."""
    calls: list[float] = []
    usual, taken_over = solved("accuracy=0.1").record, HandingOver._taken_over

    def sliding_twice(handing: HandingOver, led: Minimum, before: Problem, lowest: float) -> Minimum:
        assert lowest < led.state.energy
        calls.append(lowest)
        minimum = taken_over(handing, led, before, lowest)
        return minimum if len(calls) > 2 else replace(minimum, ending=Ending.SLID)

    monkeypatch.setattr(HandingOver, "_taken_over", sliding_twice)
    *_, step = simulation("accuracy=0.1").accepted_steps()
    assert len(calls) == 4  # on the mesh that is reported, twice on the coarser one, and on the first again
    assert step.record.certified
    assert step.record.energy == pytest.approx(usual.energy, rel=1e-4)


def test_where_nothing_is_found_beside_a_coarser_mesh_the_whole_path_is_followed(monkeypatch):
    """By the penalty, which leads, and to its end by multipliers."""
    usual, lost, whole = solved("accuracy=0.1").record, list[Minimum](), list[int]()
    settled, select = mesh_level.settled, Continuation.select

    def lost_there(*minimisers: Any, path: Continuation | None, **how: Any) -> Minimum:
        minimum = settled(*minimisers, path=path, **how)
        if path is None or len(whole) > 1:
            return minimum
        lost.append(minimum)
        return replace(minimum, ending=Ending.CONDITIONS_MISSED)

    def counted(path: Continuation, *at: Any, **how: Any) -> Minimum:
        whole.append(len(lost))  # so often in vain
        return select(path, *at, **how)

    monkeypatch.setattr(mesh_level, "settled", lost_there)
    monkeypatch.setattr(Continuation, "select", counted)
    *_, step = simulation("accuracy=0.1").accepted_steps()
    assert whole == [0, 2]  # on the first mesh, and on the one where walls were lost, by contact as stiff as there, too
    assert step.record.certified and step.record.energy_error > 0
    assert step.record.energy == pytest.approx(usual.energy, rel=0.02)  # on a branch beside it


def test_where_walls_have_slid_last_digits_are_found_on_the_next_mesh_only(monkeypatch):
    usual, slid, rested_on = solved("accuracy=0.1"), Refinement._slid, list[int]()
    rested, asked = HandingOver._rested, list[float]()

    def once(refinement: Refinement, led: Numbers, times: float) -> float:
        asked.append(slid(refinement, led, times))
        return inf if len(asked) == 1 else asked[-1]

    def counted(of: HandingOver, minimum: Minimum, lowest: float) -> Minimum:
        rested_on.append(len(minimum.state.displacement))
        return rested(of, minimum, lowest)

    monkeypatch.setattr(Refinement, "_slid", once)
    monkeypatch.setattr(HandingOver, "_rested", counted)
    *_, step = simulation("accuracy=0.1").accepted_steps()
    assert step.record.certified
    assert len(rested_on) == 1 and len(step.meshes) == len(usual.meshes) + 1
    assert step.record.energy == pytest.approx(usual.record.energy, rel=0.02)  # one mesh finer


def test_multipliers_take_over_where_walls_no_longer_overlap(monkeypatch):
    """The second-order model undoes most of the overlaps that the penalty has left, before anything is minimised."""
    left: list[float] = []
    take = handing_over.with_first_multipliers

    def overlap(minimiser: Minimiser, place: np.ndarray) -> float:
        line = minimiser.problem.linearise(minimiser.problem.at(place))
        return float(np.nanmax(-(line.gap + line.lowered)))

    def seen(minimiser: Minimiser, place: np.ndarray, *how: Any) -> np.ndarray:
        before, moved = overlap(minimiser, place), take(minimiser, place, *how)
        left.append(overlap(minimiser, moved) / before)
        return moved

    monkeypatch.setattr(handing_over, "with_first_multipliers", seen)
    *_, step = simulation("accuracy=0.1").accepted_steps()
    assert step.record.certified
    assert len(left) == 1 and left[0] < 0.1


def test_stiff_fillings_store_more_without_overlaps_and_have_not_slid():
    """The penalty stores a tenth less than the mortar, on the second mesh, where the error meets the accuracy."""
    stiff = 'lumen={kind="inclusion", material={kind="mooney-rivlin", c1=100.0, c2=100.0, bulk_modulus=10000.0}}'
    step = solved("accuracy=0.1", "tissue.rows=2", "tissue.cols=2", "load.displacement=[0.05, 0.0]", stiff)
    assert step.record.certified
    assert len(step.meshes) == 2


@pytest.mark.parametrize("sets", ["accuracy=inf", "mesh.order=2"])
def test_a_mesh_that_is_reported_has_the_contact_that_was_asked_for(sets):
    assert method(simulation(sets)) is MortarContact


def test_conditions_are_met_as_well_as_the_accuracy_asks_for():
    strict = Options().solver.continuation.condition
    asked = [Options().for_accuracy(accuracy).solver.continuation.condition for accuracy in (1e-3, 1e-2, inf)]
    assert strict < asked[0] < asked[1]
    # Where nothing is estimated, nobody asks for these numbers; they stay below what a certificate allows.
    assert asked[2] <= 1e-6
    assert Options().for_accuracy(1e-9).solver.continuation.condition == strict


def test_on_the_reported_mesh_the_conditions_hold_and_the_energy_is_the_penaltys_within_the_error():
    mortar, penalty = solved(), solved("contact.kind=penalty")
    assert mortar.record.certified and penalty.record.certified
    checks = {check.name: check.value for check in mortar.measurement.certificate.checks}
    assert checks["weighted_overlap"] < 1e-8 and checks["weighted_complementarity"] < 1e-8
    assert mortar.record.energy == pytest.approx(penalty.record.energy, rel=0.005)


def test_the_mortar_takes_hardly_more_iterations_and_factorisations_than_the_penalty():
    mortar, penalty = solved(), solved("contact.kind=penalty")
    assert mortar.record.iterations <= 1.25 * penalty.record.iterations
    assert mortar.record.factorisations <= 1.25 * penalty.record.factorisations


def test_to_finer_meshes_leads_the_penalty_that_the_accuracy_asks_for():
    led, meant = (simulation(sets).refinement.level(1) for sets in ("accuracy=0.01", "contact.kind=penalty"))
    problems = led.problem_of("released", only_leads=True), meant.problem
    one, two = (next(term for term in each.terms if isinstance(term, ContactTerm)) for each in problems)
    assert type(one.method) is type(two.method) is PenaltyContact
    np.testing.assert_allclose(one.stiffness, two.stiffness, rtol=1e-12)


def test_where_the_penalty_comes_back_to_where_it_led_from_nothing_has_slid():
    """Rings of straight edges that lock: gaps that are closed on average let them store 5 % less than closed points."""
    energy = {}
    for kind in ("penalty", "mortar"):
        (step,) = ngcell.simulate(ngcell.read_case("press-fit", ["mesh.order=1", f"contact.kind={kind}"]))
        energy[kind] = step.record.energy
    assert energy["mortar"] == pytest.approx(0.95 * energy["penalty"], rel=0.02)
