"""Multipliers take over from a penalty, beside a saddle as beside a minimum."""

from __future__ import annotations

import numpy as np
from netgen import occ

from ngcell.build.simulation import Simulation
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Mortar
from ngcell.solve.handing_over import HandingOver
from ngcell.solve.minimum import Minimum
from ngcell.solve.proximal import ProximalTerm

_SOLID = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=10.0)


def _simulation() -> Simulation:
    """A slender block that is pressed along its axis, beside another: straight, it is on a saddle."""
    face = occ.Rectangle(0.1, 2.0).Face()
    face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = "low", "high"
    beside = occ.MoveTo(0.3, 0.0).Rectangle(0.2, 2.0).Face()
    beside.edges.Min(occ.Y).name = "foot"
    bodies = Body(face, _SOLID, "block"), Body(beside, _SOLID, "beside")
    supports = (BodySupport("low"), BodySupport("high", translation=(0.0, -0.1)), BodySupport("foot"))
    return Simulation(BodyScene(bodies, supports, size=0.1, order=2, levels=1, contact=Mortar(), accuracy=0.1))


def test_a_saddle_is_left_before_last_digits_are_looked_for(monkeypatch):
    built = _simulation()
    released, load = built.released, 1.0
    released.apply(load)
    leads = released.minimisers[-2]
    rest = np.zeros(built.space.unknowns)
    start = leads.predict(rest, built.motion.imposed(rest, load), built.continuation.scale)
    led = leads.minimise(start, ProximalTerm(released.path.scale * released.path.options.recentred, start))
    assert led.is_found and led.state.energy > 9e-4
    looked: list[float] = []
    rested = HandingOver._rested

    def noted(handing: HandingOver, minimum: Minimum, lowest: float) -> Minimum:
        looked.append(minimum.state.energy)
        return rested(handing, minimum, lowest)

    monkeypatch.setattr(HandingOver, "_rested", noted)
    found = released.handed_over(led, leads.problem)
    assert found.is_found
    assert looked[0] < 0.5 * led.state.energy
    assert found.state.energy < 0.5 * led.state.energy
