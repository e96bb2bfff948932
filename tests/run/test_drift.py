"""A load that drives a body to where nothing can hold it is told before anything is solved; others are left alone."""

from __future__ import annotations

from math import inf

import pytest
from netgen import occ

from ngcell.build.simulation import Simulation
from ngcell.errors import CaseError
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Traction

_RUBBER = MooneyRivlin(c1=0.25, c2=0.25, bulk_modulus=10)
_AT = {"held": (0.0, 0.0), "loaded": (1.0, 0.0), "between": (0.0, 1.0), "far": (9.0, 0.1), "above": (1.0, 1.5)}


def _scene(force: tuple[float, float], bodies: tuple[str, ...], held: tuple[str, ...]) -> BodyScene:
    made = []
    for name in bodies:
        face = occ.MoveTo(*_AT[name]).Rectangle(1, 1).Face()
        face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = f"{name}_low", f"{name}_top"
        made.append(Body(face, _RUBBER, name))
    supports = tuple(BodySupport(f"{name}_low") for name in held)
    load = Traction(boundary="loaded_low", vector=force)
    return BodyScene(tuple(made), supports, loads=(load,), size=0.5, order=1, levels=1, accuracy=inf)


@pytest.mark.parametrize(
    ("force", "bodies", "held"),
    [
        ((0.1, 0.0), ("held", "loaded"), ("held",)),  # away from it
        ((0.0, -0.1), ("held", "loaded"), ("held",)),  # along its side
        ((0.05, 0.1), ("held", "loaded", "far"), ("held", "far")),  # past the other one
        ((0.1, 0.0), ("held", "loaded", "far"), ("held",)),  # what is in the way is not held
    ],
)
def test_a_body_that_nothing_can_hold_is_a_bad_case(force, bodies, held):
    with pytest.raises(CaseError, match="loaded has no support.*nothing can hold it"):
        Simulation(_scene(force, bodies, held))


@pytest.mark.parametrize(
    ("force", "bodies", "held"),
    [
        ((-0.1, 0.0), ("held", "loaded"), ("held",)),  # against it
        ((0.1, 0.0), ("held", "loaded", "far"), ("held", "far")),
        ((0.0, 0.1), ("held", "loaded", "above"), ("held", "above")),
        ((0.1, 0.0), ("held", "loaded", "far"), ("held", "loaded")),
        ((-0.1, 0.1), ("held", "loaded", "between"), ("held",)),  # it may be wedged
    ],
)
def test_others_are_left_to_the_solver(force, bodies, held):
    Simulation(_scene(force, bodies, held))
