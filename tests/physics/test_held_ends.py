"""Walls that end where both bodies are held: the force between them by the penalty is that of the mortar."""

from __future__ import annotations

import pytest
from netgen import occ

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Mortar, Penalty, Traction


def strip(name: str, low: float) -> Body:
    face = occ.MoveTo(0, low).Rectangle(1, 0.3).Face()
    face.edges.Min(occ.X).name = f"{name}_end"
    face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = f"{name}_low", f"{name}_top"
    return Body(face, MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0), name)


def pressed(contact: Penalty | Mortar) -> Step:
    held = BodySupport("lower_low"), BodySupport("lower_end"), BodySupport("upper_end")
    load = (Traction(boundary="upper_top", vector=(0.0, -0.2)),)
    strips = strip("lower", 0.0), strip("upper", 0.3)
    scene = BodyScene(strips, held, loads=load, size=0.1, levels=1, contact=contact, accuracy=0.01)
    *_, step = Simulation(scene).accepted_steps()
    return step


def test_the_penalty_presses_as_the_mortar_does_within_the_told_errors():
    penalty, mortar = pressed(Penalty()).record, pressed(Mortar()).record
    assert penalty.certified and mortar.certified
    told = penalty.contact_force_error + mortar.contact_force_error
    assert told < 0.01 * mortar.contact_force
    assert penalty.contact_force == pytest.approx(mortar.contact_force, abs=told)
