"""Walls that a support guides in a plane, with all bodies on one side of it, are walls no more."""

from __future__ import annotations

from dataclasses import replace
from math import inf, log

import pytest
from netgen import occ

import ngcell
from ngcell.build.discretisation import discretise
from ngcell.build.simulation import Simulation
from ngcell.scene.bodies import Body, BodyScene, BodySupport
from tests.physics.rig import rubber

FLOOR = BodySupport("lower_bottom", components=(False, True))
SIDES = tuple(BodySupport(f"{body}_{side}", components=(True, False)) for body in ("lower", "upper")
              for side in ("left", "right"))


def block(name: str, low: tuple[float, float], high: tuple[float, float], size: float = 0.5) -> occ.Face:
    face = occ.MoveTo(*low).Rectangle(high[0] - low[0], high[1] - low[1]).Face().faces[0]
    face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = f"{name}_bottom", f"{name}_top"
    face.edges.Min(occ.X).name, face.edges.Max(occ.X).name = f"{name}_left", f"{name}_right"
    face.maxh = size
    return face


def stack(supports=(), *, upper=((0, 1), (1, 2)), kappa: float = 100.0, sizes=(0.5, 0.5), walls=(), **options):
    bodies = [
        Body(block("lower", (0, 0), (1, 1), sizes[0]), rubber(kappa), "lower", walls=walls),
        Body(block("upper", *upper, sizes[1]), rubber(kappa), "upper"),
    ]
    return BodyScene(bodies, supports, accuracy=inf, levels=1, **options)


def walls_of(scene: BodyScene) -> set[str]:
    return set(discretise(scene).space.bodies.wall_names.split("|"))


ALL = {f"{body}_{side}" for body in ("lower", "upper") for side in ("left", "right", "top", "bottom")}


def test_sides_in_slippery_walls_and_the_floor_are_no_walls():
    assert walls_of(stack((FLOOR, *SIDES))) == {"lower_top", "upper_bottom", "upper_top"}


def test_a_pressed_ceiling_and_sides_that_nothing_holds_stay_walls():
    ceiling = BodySupport("upper_top", translation=(0.0, -0.1), components=(False, True))
    assert walls_of(stack((FLOOR, ceiling))) == ALL - {"lower_bottom"}


def test_the_top_of_a_held_block_below_another_stays_a_wall():
    held = [BodySupport(f"lower_{side}") for side in ("left", "right", "bottom", "top")]
    assert "lower_top" in walls_of(stack(held))


def test_a_side_that_another_body_reaches_past_stays_a_wall():
    assert "lower_left" in walls_of(stack((FLOOR, *SIDES), upper=((-0.5, 1), (1, 2))))


def test_a_side_that_a_support_drives_bodies_past_stays_a_wall():
    left = BodySupport("upper_top", translation=(-2.0, 0.0))
    walls = walls_of(stack((FLOOR, SIDES[0], SIDES[1], left)))
    assert {"lower_left"} <= walls and "lower_right" not in walls


def test_a_side_held_along_itself_stays_a_wall():
    assert "lower_left" in walls_of(stack((FLOOR, BodySupport("lower_left", components=(False, True)))))


def test_what_a_scene_calls_a_wall_stays_one():
    assert "lower_left" in walls_of(stack((FLOOR, *SIDES), walls=("lower_left",)))


def test_a_bent_side_stays_a_wall():
    half = (occ.Circle((0, 0), 1).Face() * occ.MoveTo(-2, 0).Rectangle(4, 2).Face()).faces[0]
    for edge in half.edges:
        edge.name = "flat" if abs(edge.center.y) < 1e-9 else "round"
    scene = BodyScene([Body(half, rubber(10.0), "half")], [BodySupport("flat", components=(False, True)),
                                                           BodySupport("round")], size=0.5, accuracy=inf)
    assert walls_of(scene) == {"round"}


def test_they_are_as_stiff_as_the_accuracy_asks():
    """The penalty's own error is a quarter of the accuracy at most; it was 1.4 times as large, and not certified."""
    kappa, stretch = 5000.0, 0.98
    ceiling = BodySupport("upper_top", translation=(0.0, 2 * (stretch - 1)), components=(False, True))
    scene = replace(stack((FLOOR, *SIDES, ceiling), kappa=kappa, sizes=(0.25, 0.34)), accuracy=0.01)
    step = ngcell.simulate(scene)[-1]
    assert step.record.certified
    assert step.record.plate_force_y == pytest.approx(kappa * log(stretch) / stretch, rel=0.0025)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_confined_blocks_that_hardly_change_their_volume_are_compressed_alike(order):
    """Exact: F = diag(1, 0.98) all over; a penalty yields by what the certificate tells, 2 %."""
    kappa, stretch = 5000.0, 0.98
    ceiling = BodySupport("upper_top", translation=(0.0, 2 * (stretch - 1)), components=(False, True))
    scene = stack((FLOOR, *SIDES, ceiling), kappa=kappa, sizes=(0.25, 0.34), order=order)
    *_, step = Simulation(scene).accepted_steps()
    volumetric = 2 * kappa / 2 * log(stretch) ** 2
    assert step.record.certified
    assert step.record.energy == pytest.approx(volumetric, rel=0.02)
    assert step.record.plate_force_y == pytest.approx(kappa * log(stretch) / stretch, rel=0.02)
    assert ngcell.simulate(scene)[-1].record.energy == step.record.energy
