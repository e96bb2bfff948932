"""The mortar method on the meshes of a scene: it acts where numbers are reported, and ends where accuracy is met."""

from __future__ import annotations

from functools import cache
from math import inf

import numpy as np
import pytest

import ngcell
from ngcell.build.mesh_level import Level, Refined
from ngcell.build.options import Options
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.terms import ContactTerm


def simulation(*sets: str) -> Simulation:
    usual = ["load.displacement=[0.4, 0.0]", "load.levels=1", "contact.kind=mortar"]
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
    monkeypatch.setattr(Level, "finished", lambda level, led: seen.append((led.level, False)) or finished(level, led))
    *_, step = simulation().accepted_steps()
    assert step.record.certified
    most = len(step.meshes) - 1
    assert most > 1
    assert seen[-most - 1 :] == [*((level, True) for level in range(1, most + 1)), (most, False)]


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
