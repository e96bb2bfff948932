"""Cohesion: two blocks separate as the law says, and the work of separating them is its energy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import inf

import numpy as np
import pytest
from scipy.integrate import simpson

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.scene import Block, BodyCase, Cohesion, MooneyRivlin
from ngcell.scene.case_of_bodies import SupportEntry
from ngcell.scene.mesh import BodyMeshChoice

WIDTH, ENERGY = 0.5, 0.01
MATERIAL = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=20.0)


@dataclass(frozen=True)
class Pulled:
    """Blocks pulled apart: the law and the accepted steps."""

    law: Cohesion
    prescribed_displacement: float
    steps: list[Step]

    def column(self, name: str) -> np.ndarray:
        return np.array([0.0, *(getattr(step.record, name) for step in self.steps)])

    @property
    def work(self) -> float:
        """Work of the support by Simpson's rule."""
        return float(simpson(self.column("plate_force_y"), self.prescribed_displacement * self.column("load_factor")))


def blocks_case(prescribed_displacement: float, steps: int, cohesion: Cohesion | None) -> BodyCase:
    """Two halves of blocks of height 0.5 along their plane of symmetry; the upper one is moved up."""

    def block(name: str, bottom: float, wall: str) -> Block:
        low, high = (0.0, bottom), (WIDTH, bottom + 0.5)
        return Block(name=name, low=low, high=high, size=0.5, walls=(wall,), material=MATERIAL)

    return BodyCase(
        levels=1,
        steps=steps,
        bodies=(block("lower", 0.0, "top"), block("upper", 0.5, "bottom")),
        supports=(
            SupportEntry(boundary="lower_left", components="x"),
            SupportEntry(boundary="upper_left", components="x"),
            SupportEntry(boundary="lower_bottom", components="y"),
            SupportEntry(boundary="upper_top", translation=(0.0, prescribed_displacement), components="y"),
        ),
        cohesion=cohesion,
        mesh=BodyMeshChoice(order=1),
        accuracy=inf,
    )


@cache
def pulled(strength: float, peaks: float, steps: int) -> Pulled:
    """Blocks pulled apart by so many times the opening at the peak."""
    law = Cohesion(strength=strength, energy=ENERGY)
    case = blocks_case(peaks * law.peak, steps, law)
    return Pulled(law, peaks * law.peak, list(Simulation(case).accepted_steps()))


def test_the_work_of_separation_is_the_separation_energy():
    blocks = pulled(0.1, 16.0, 160)
    assert blocks.work / WIDTH == pytest.approx(ENERGY, rel=1e-4)
    last = blocks.steps[-1].record
    spent = float(blocks.law.work(np.array(last.mean_gap)))
    assert spent == pytest.approx(ENERGY, rel=2e-5)  # 14 times the opening at the peak
    assert (last.separation_energy + last.energy) / WIDTH == pytest.approx(spent, rel=1e-8)
    assert last.dissipation < 1e-4 * ENERGY * WIDTH
    assert last.bonded_share == 0
    assert all(step.record.certified for step in blocks.steps)


def test_traction_follows_the_law():
    blocks = pulled(0.1, 16.0, 160)
    traction, opening = blocks.column("plate_force_y") / WIDTH, blocks.column("mean_gap")
    np.testing.assert_allclose(traction, blocks.law.traction(opening), atol=1e-6 * blocks.law.strength)
    assert traction.max() == pytest.approx(blocks.law.strength, rel=2e-3)  # of the steps next to the peak


def test_blocks_that_snap_lose_what_they_had_stored_and_the_account_closes():
    """Blocks softer than the falling branch: at held supports there is no equilibrium behind the peak."""
    strength = 1.0
    law = Cohesion(strength=strength, energy=ENERGY)
    assert strength / (np.e * law.peak) > 4 * MATERIAL.bulk_modulus  # falls faster than two blocks could give way
    blocks = pulled(strength, 180.0, 40)
    last = blocks.steps[-1].record
    assert last.bonded_share == 0 and last.energy < 1e-3 * ENERGY * WIDTH
    assert last.dissipation > 0.1 * ENERGY * WIDTH
    assert last.separation_energy / WIDTH == pytest.approx(ENERGY, rel=1e-3)
    work = np.trapezoid(blocks.column("plate_force_y"), blocks.column("plate_displacement"))
    # The rule does not see where within its step the force falls.
    unseen = blocks.column("plate_force_y").max() * np.diff(blocks.column("plate_displacement")).max() / 2
    assert work == pytest.approx(last.separation_energy + last.dissipation, abs=1.2 * unseen)
    assert all(step.record.certified for step in blocks.steps)


def test_what_has_been_separated_stays_so():
    blocks = pulled(0.1, 16.0, 160)
    for name, sign in (("separation_energy", 1), ("bonded_share", -1), ("dissipation", 1)):
        values = blocks.column(name)[1:]
        assert (sign * np.diff(values) >= -1e-15).all(), name


def test_contact_in_compression_is_unchanged():
    free, bonded = (pressed(cohesion) for cohesion in (None, Cohesion(strength=0.1, energy=ENERGY)))
    assert bonded.record.plate_force_y == pytest.approx(free.record.plate_force_y, rel=1e-7)
    assert bonded.record.smallest_gap == pytest.approx(free.record.smallest_gap, rel=1e-6)
    assert bonded.record.bonded_share == 1 and bonded.record.separation_energy < 1e-12


def pressed(cohesion: Cohesion | None) -> Step:
    """The blocks, pressed together by a tenth."""
    return list(Simulation(blocks_case(-0.1, 1, cohesion)).accepted_steps())[-1]


def test_bonds_that_were_opened_go_back_along_the_secant():
    law = Cohesion(strength=0.1, energy=ENERGY)
    levels = (0.5, 1.0, 0.5, 0.0)
    case = blocks_case(6.0 * law.peak, 8, law).model_copy(update={"levels": levels})
    steps = list(Simulation(case).accepted_steps())
    rows = [step.record for step in steps]
    assert all(row.certified for row in rows)
    farthest = max(range(len(rows)), key=lambda n: rows[n].load_factor)
    secant = rows[farthest].plate_force_y / rows[farthest].mean_gap
    for row in rows[farthest:-1]:
        assert row.plate_force_y == pytest.approx(secant * row.mean_gap, rel=1e-6)
        assert row.separation_energy + row.dissipation >= rows[farthest].separation_energy - 1e-12
    assert [rows[farthest].load_factor, rows[-1].load_factor] == [1.0, 0.0]
    assert abs(rows[-1].plate_force_y) < 1e-9 and rows[-1].energy < 1e-12
