"""A disc in a fitting ring whose rim shrinks: the deformation is that of one solid disc, the same everywhere.

The pressure between them has no resultant, on the disc as on the ring.
"""

from __future__ import annotations

from math import inf

import pytest
from netgen import occ

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin

RUBBER = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)


def disc(radius: float, edge: str) -> occ.Face:
    face = occ.WorkPlane().Circle(0, 0, radius).Face()
    face.edges.name = edge
    return face


def shrunk(accuracy: float, *bodies: Body) -> Step:
    rim = BodySupport("rim", gradient=((-0.1, 0.0), (0.0, -0.1)))
    *_, step = Simulation(BodyScene(bodies, (rim,), size=0.25, levels=1, accuracy=accuracy)).accepted_steps()
    return step


@pytest.mark.parametrize("accuracy", [inf, 0.01])
def test_a_disc_in_a_shrinking_ring_is_one_disc(accuracy: float) -> None:
    """It was not finished after 400 s; then an overlap over no resultant at all was told as a gap's error of 40 000."""
    whole = shrunk(inf, Body(disc(1.0, "rim"), RUBBER, "whole"))
    ring = Body(disc(1.0, "rim") - disc(0.5, "seat"), RUBBER, "ring")
    both = shrunk(accuracy, Body(disc(0.5, "fit"), RUBBER, "disc"), ring)
    assert both.record.certified
    assert both.record.energy == pytest.approx(whole.record.energy, rel=0.002)
    assert both.record.factorisations < 1000
    (wall,) = both.walls
    assert wall.normal_force > 10
