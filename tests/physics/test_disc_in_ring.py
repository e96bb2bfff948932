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


def of_one_disc() -> float:
    return shrunk(inf, Body(disc(1.0, "rim"), RUBBER, "whole")).record.energy


def of_disc_and_ring(accuracy: float) -> Step:
    ring = Body(disc(1.0, "rim") - disc(0.5, "seat"), RUBBER, "ring")
    return shrunk(accuracy, Body(disc(0.5, "fit"), RUBBER, "disc"), ring)


def test_a_disc_in_a_shrinking_ring_is_one_disc() -> None:
    """It was not finished after 400 s, and takes 121 factorisations."""
    both = of_disc_and_ring(inf)
    assert both.record.certified
    assert both.record.energy == pytest.approx(of_one_disc(), rel=0.002)
    assert both.record.factorisations < 250
    (wall,) = both.walls
    assert wall.normal_force > 10


def test_what_passes_through_itself_by_soft_contact_is_found_on_the_next_mesh_by_contact_as_stiff_as_before() -> None:
    """By contact as soft as it begins, the disc sinks into the ring there; no error could be told."""
    both = of_disc_and_ring(0.1)
    assert both.record.certified and len(both.meshes) > 1
    assert abs(both.record.energy - of_one_disc()) < both.record.energy_error < 0.01 * both.record.energy
