"""Two blocks that are pressed together know nothing of bodies far away, whatever these are and do."""

from __future__ import annotations

from functools import cache
from math import inf

import pytest
from netgen import occ

from ngcell.build.simulation import Simulation
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


@cache
def _of_the_pair(far: str, method: str) -> tuple[float, float, bool]:
    """Return normal force and mean gap of the pair, and whether its overlaps pass."""
    others, held = _FAR[far]()
    bodies = (_block("lower", 0, 1, 0, 1), _block("upper", -0.1, 0.7, 1, 0.7), *others)
    supports = (BodySupport("lower_low"), BodySupport("upper_top", translation=(0.0, -0.25)), *held)
    scene = BodyScene(bodies, supports, size=0.34, order=2, levels=1, accuracy=inf, contact=_METHODS[method])
    *_, step = Simulation(scene).accepted_steps()
    (wall,) = (wall for wall in step.walls if (wall.cell_a, wall.cell_b) == (0, 1))
    failed = [check.name for check in step.report.certificate.checks if not check.passed]
    return wall.normal_force, wall.mean_gap, "penetration_over_wall" not in failed


@pytest.mark.parametrize(
    ("far", "method"),
    [(far, method) for far in list(_FAR)[1:] for method in _METHODS if method == "penalty" or "pressed" not in far],
)
def test_a_far_body_changes_nothing(far: str, method: str) -> None:
    force, gap, passes = _of_the_pair(far, method)
    alone, gap_alone, passes_alone = _of_the_pair("nothing", method)
    assert force == pytest.approx(alone, rel=1e-8)
    assert gap == pytest.approx(gap_alone, abs=1e-9)
    assert passes_alone and (passes or far.endswith("pressed"))
