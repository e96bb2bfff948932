"""K3: two rings that just touch; the outer one is pulled away from the inner one, which nothing holds."""

from __future__ import annotations

from functools import cache
from math import inf, pi, sqrt

import numpy as np
import pytest

from ngcell.scene.bodies import Body, BodyScene
from tests.physics.rig import Equilibrium, Rig, ring, rubber, swelling, work_is_change_of_energy
from tools.references.radial import RadialSolid, ring_with_free_rim

RIM, FARTHEST = 1.5, 2.0
#: Growth of the outer ring in a step; wider ones cost more.
STRIDE = 0.025


@cache
def path_to_the_farthest(kappa: float) -> list[Equilibrium]:
    return pulled(FARTHEST, kappa, round((FARTHEST - RIM) / STRIDE))


def pulled(radius: float, kappa: float, levels: int = 4, order: int = 3) -> list[Equilibrium]:
    scene = BodyScene(
        [Body(ring(0.5, 1.0), rubber(kappa), "inner"), Body(ring(1.0, RIM), rubber(kappa), "outer")],
        [swelling("outer_outline", radius, RIM)],
        size=0.25,
        order=order,
        levels=levels,
        accuracy=inf,
    )
    return list(Rig(scene).accepted_steps())


def gap_between(state: Equilibrium) -> float:
    return state.radius("outer_hole0") - state.radius("inner_outline")


@pytest.mark.parametrize(("radius", "incompressible"), [(1.6, 0.144552), (2.0, 0.658312)])
def test_the_inner_ring_stays_unstressed_and_the_gap_is_that_of_the_outer_ring(radius, incompressible):
    kappa = 1000.0
    path = path_to_the_farthest(kappa)[: round((radius - RIM) / STRIDE)]
    final = path[-1]
    exact = ring_with_free_rim(RadialSolid(0.8, 0.2, kappa), RIM, radius, 1.0)
    assert sqrt(1 + radius**2 - RIM**2) - 1 == pytest.approx(incompressible, abs=1e-6)
    assert abs(final.body_energy(0)) < 1e-12 * final.accepted.minimum.state.energy
    assert gap_between(final) == pytest.approx(exact.inner - 1, abs=2e-5)
    assert gap_between(final) == pytest.approx(incompressible, abs=1.0 / kappa)
    pull = final.work_rate / (2 * pi * radius * (FARTHEST - RIM))
    assert pull == pytest.approx(-exact.outer_pressure, rel=1e-5)
    assert np.abs(final.vertices("inner_outline").mean(0)).max() < 1e-3
    assert np.abs(final.contact_forces.on_body).max() < 1e-8
    assert work_is_change_of_energy(path)


def test_a_softer_bulk_modulus_follows_the_radial_solution():
    exact = ring_with_free_rim(RadialSolid(0.8, 0.2, 100.0), RIM, 1.6, 1.0)
    final = pulled(1.6, 100.0)[-1]
    assert gap_between(final) == pytest.approx(exact.inner - 1, abs=2e-5)
    assert gap_between(final) != pytest.approx(0.144552, abs=1e-3)
