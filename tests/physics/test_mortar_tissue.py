"""The sheared tissue with the mortar: certified, the same from both strategies, and in balance across a cut (K6)."""

from __future__ import annotations

from functools import cache, partialmethod

import numpy as np
import pytest

import ngcell
from ngcell.build.checkpoint import Checkpoint
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.contact.methods.by_mortar import Mortar
from ngcell.contact.options import ContactOptions
from ngcell.results.forces import contact_forces
from ngcell.solve.step import Accepted


def case(strategy: str = "sddp", contact: str = "mortar", displacement: float = 0.5) -> ngcell.Case:
    sets = [
        f"load.displacement=[{displacement}, 0.0]",
        "load.levels=[1.0]",
        f"strategy.kind={strategy}",
        f"contact.kind={contact}",
    ]
    return ngcell.read_case("shear-empty-3x3", [*sets, "accuracy=inf"])


@cache
def solved(strategy: str = "sddp", contact: str = "mortar", displacement: float = 0.5) -> tuple[Simulation, Step]:
    simulation = Simulation(case(strategy, contact, displacement))
    *_, final = simulation.accepted_steps()
    return simulation, final


@pytest.mark.parametrize("strategy", ["sddp", "single-step"])
def test_the_sheared_tissue_is_certified(strategy):
    _, final = solved(strategy)
    checks = {check.name: check.value for check in final.measurement.certificate.checks}
    assert final.record.certified
    assert checks["weighted_overlap"] < 1e-8 and checks["weighted_complementarity"] < 1e-8
    assert checks["penetration_over_wall"] < 0.01


def test_both_strategies_end_at_the_same_equilibrium():
    (_, one), (_, two) = solved("sddp"), solved("single-step")
    assert one.record.energy == pytest.approx(two.record.energy, rel=1e-8)
    assert one.record.plate_force_x == pytest.approx(two.record.plate_force_x, rel=1e-6)
    assert np.abs(one.displacement - two.displacement).max() < 1e-4


def test_energy_and_forces_are_those_of_a_penalty_up_to_its_overlaps():
    (_, mortar), (_, penalty) = solved(), solved(contact="penalty")
    assert mortar.record.energy == pytest.approx(penalty.record.energy, rel=0.01)
    assert mortar.record.plate_force_y == pytest.approx(penalty.record.plate_force_y, rel=0.02)


def test_the_stiffness_of_the_penalty_terms_leaves_no_trace(monkeypatch):
    _, usual = solved()
    options = ContactOptions(mortar_multiple=10 * ContactOptions().mortar_multiple)
    monkeypatch.setattr(Mortar, "stages", partialmethod(Mortar.stages, options=options))
    *_, other = Simulation(case()).accepted_steps()
    assert other.record.energy == pytest.approx(usual.record.energy, rel=1e-7)


@cache
def followed(contact: str) -> tuple[Simulation, Accepted]:
    simulation = Simulation(case(contact=contact))
    *_, accepted = simulation.follow(Checkpoint())
    return simulation, accepted


@pytest.mark.parametrize("contact", ["mortar", "penalty"])
@pytest.mark.parametrize("cut", [1, 2])
def test_k6_the_plates_pull_as_hard_as_walls_press_across_a_cut(contact, cut):
    """The cut runs between two rows, through contact only; what the last proximal term holds counts apart."""
    simulation, accepted = followed(contact)
    problem, state, proximal = simulation.problem, accepted.minimum.state, accepted.minimum.proximal
    pull = -proximal.gradient(state.displacement, problem.metric)
    support = problem.unknowns.reactions(problem.gradient(state) - pull)
    above = np.arange(9) // 3 >= cut
    forces = contact_forces(problem, state)
    crosses = above[forces.bodies[:, 0]] != above[forces.bodies[:, 1]]
    upwards = np.where(above[forces.bodies[:, 0]], 1, -1)[crosses, None]
    across = (upwards * forces.force[crosses]).sum(0)
    plate, held = (problem.space.resultants(force)[above].sum(0) for force in (support, pull))
    size = np.linalg.norm(plate)
    assert size > 1e-3 and np.linalg.norm(held) < 1e-6 * size
    np.testing.assert_allclose(across + plate, 0, atol=1e-6 * size)
    np.testing.assert_allclose(across + plate + held, 0, atol=1e-9 * size)
