"""Two blocks that are pressed together know nothing of bodies far away, whatever these are and do."""

from __future__ import annotations

from functools import cache
from math import inf
from typing import Any

import pytest
from netgen import occ

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.results.record import WallRecord
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Mortar, Penalty

_METHODS = {"penalty": Penalty(), "mortar": Mortar()}


def _block(name: str, left: float, width: float, low: float, height: float, modulus: float = 1.0) -> Body:
    face = occ.MoveTo(left, low).Rectangle(width, height).Face()
    face.edges.Min(occ.X).name, face.edges.Min(occ.Y).name = f"{name}_left", f"{name}_low"
    face.edges.Max(occ.Y).name = f"{name}_top"
    return Body(face, MooneyRivlin(c1=modulus / 4, c2=modulus / 4, bulk_modulus=10 * modulus), name)


def _pressed(modulus: float) -> tuple[tuple[Body, ...], tuple[BodySupport, ...]]:
    bodies = _block("far", 40, 1, 40, 0.3, modulus), _block("over", 40, 1, 40.3, 0.3, modulus)
    return bodies, (BodySupport("far_low"), BodySupport("over_top", translation=(0.0, -0.2)))


_FAR = {
    "nothing": lambda: ((), ()),
    "a body that is thin": lambda: ((_block("far", 40, 1, 40, 0.05),), (BodySupport("far_left"),)),
    "a body that is soft": lambda: ((_block("far", 40, 1, 40, 1, 0.01),), (BodySupport("far_low"),)),
    "a body that is stiff": lambda: ((_block("far", 40, 1, 40, 1, 1000.0),), (BodySupport("far_low"),)),
    "bodies that are pressed": lambda: _pressed(1.0),
    "stiff bodies that are pressed": lambda: _pressed(100.0),
}


def _step(far: str, method: str, **choices: Any) -> tuple[Step, WallRecord]:
    """Return the step of the pair and a far body, and what is told of the pair."""
    others, held = _FAR[far]()
    bodies = (_block("lower", 0, 1, 0, 1), _block("upper", -0.1, 0.7, 1, 0.7), *others)
    supports = (BodySupport("lower_low"), BodySupport("upper_top", translation=(0.0, -0.25)), *held)
    *_, step = Simulation(
        BodyScene(bodies, supports, size=0.34, levels=1, contact=_METHODS[method], **choices)
    ).accepted_steps()
    return step, _of_the_two(step)


def _of_the_two(step: Step) -> WallRecord:
    (wall,) = (wall for wall in step.walls if (wall.cell_a, wall.cell_b) == (0, 1))
    return wall


@cache
def _of_the_pair(far: str, method: str) -> tuple[float, float, bool]:
    """Return normal force and mean gap of the pair, and whether its overlaps pass.

    Of order 2 and 3 such large elements have several minima, 0.4 to 1 % apart in force, and which of them is found
    depends on all bodies.
    """
    step, wall = _step(far, method, order=4, accuracy=inf)
    failed = [check.name for check in step.report.certificate.checks if not check.passed]
    return wall.normal_force, wall.mean_gap, "penetration_over_wall" not in failed


@pytest.mark.parametrize(
    ("far", "method"),
    [(far, method) for far in list(_FAR)[1:] for method in _METHODS if method == "penalty" or "thin" in far],
)
def test_a_far_body_changes_nothing(far: str, method: str) -> None:
    force, gap, passes = _of_the_pair(far, method)
    alone, gap_alone, passes_alone = _of_the_pair("nothing", method)
    assert force == pytest.approx(alone, rel=1e-8)
    assert gap == pytest.approx(gap_alone, abs=1e-9)
    assert passes_alone and (passes or far.endswith("pressed"))


@cache
def _estimated(far: str) -> tuple[Step, WallRecord]:
    return _step(far, "penalty", accuracy=0.05)


@pytest.mark.parametrize("far", ["a body that is thin", "a body that is stiff"])
def test_a_far_body_changes_neither_the_mesh_nor_the_estimated_error(far: str) -> None:
    """A thin one once set the gap that errors of gaps are relative to: two meshes more, other numbers, no certificate.
    """
    (step, wall), (alone, wall_alone) = _estimated(far), _estimated("nothing")
    assert step.record.certified and alone.record.certified
    assert [mesh["order"] for mesh in step.meshes] == [mesh["order"] for mesh in alone.meshes]
    assert wall.normal_force == pytest.approx(wall_alone.normal_force, rel=1e-7)
    assert wall.mean_gap == pytest.approx(wall_alone.mean_gap, rel=1e-4)
    assert step.record.energy_error == pytest.approx(alone.record.energy_error, rel=1e-3)


def _box(name: str, low: tuple[float, float, float], size: tuple[float, float, float]) -> Body:
    solid = occ.Box(occ.Pnt(*low), occ.Pnt(*(start + length for start, length in zip(low, size, strict=True))))
    solid.faces.Min(occ.Z).name, solid.faces.Max(occ.Z).name = f"{name}_low", f"{name}_top"
    return Body(solid, MooneyRivlin(c1=0.25, c2=0.25, bulk_modulus=10.0), name)


def _pair_of_solids(far_height: float, accuracy: float) -> tuple[float, float]:
    """Return normal force and mean gap of two boxes beside a third one of a height, or none."""
    bodies = [_box("lower", (0, 0, 0), (1, 1, 1)), _box("upper", (-0.1, 0.1, 1), (0.7, 0.7, 0.7))]
    supports = [BodySupport("lower_low"), BodySupport("upper_top", translation=(0.0, 0.0, -0.25))]
    if far_height:
        bodies.append(_box("far", (40, 0, 40), (0.4, 0.4, far_height)))
        supports.append(BodySupport("far_low"))
    scene = BodyScene(tuple(bodies), tuple(supports), size=1.0, order=1, levels=1, accuracy=accuracy)
    wall = _of_the_two(list(Simulation(scene).accepted_steps())[-1])
    return wall.normal_force, wall.mean_gap


def test_a_far_solid_changes_nothing() -> None:
    """At a finite accuracy one that is thin limited the steps of all, and moved the force by 2 %."""
    assert _pair_of_solids(0.2, accuracy=0.15) == pytest.approx(_pair_of_solids(0.0, accuracy=0.15), rel=1e-8)
