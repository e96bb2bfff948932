"""Slender blocks buckle, jumps do not tunnel, and loads that nothing balances are told at once."""

from __future__ import annotations

from functools import cache
from math import inf

import pytest
from netgen import occ

from ngcell.errors import CaseError
from ngcell.results.record import StepRecord
from ngcell.run import simulate
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Traction
from ngcell.solve.strategies.load_stepping import LoadStepping
from ngcell.solve.strategies.strategy import Strategy

_RUBBER = MooneyRivlin(c1=0.25, c2=0.25, bulk_modulus=50)


def _block(name: str, left: float, width: float, low: float, height: float) -> Body:
    face = occ.MoveTo(left, low).Rectangle(width, height).Face()
    sides = {"left": face.edges.Min(occ.X), "right": face.edges.Max(occ.X), "low": face.edges.Min(occ.Y)}
    for side, edge in {**sides, "top": face.edges.Max(occ.Y)}.items():
        edge.name = f"{name}_{side}"
    return Body(face, _RUBBER, name)


@cache
def _column(others: int, strategy: Strategy | None = None) -> StepRecord:
    far = [_block(f"far{n}", 5 + 3 * n, 1.0, 0.0, 1.0) for n in range(others)]
    supports = [BodySupport("col_low"), BodySupport("col_top", translation=(0.0, -0.1))]
    supports += [BodySupport(f"{body.name}_low") for body in far]
    bodies = (_block("col", 0.0, 0.1, 0.0, 2.0), *far)
    scene = BodyScene(bodies, tuple(supports), size=0.1, levels=1, accuracy=inf, strategy=strategy)
    return simulate(scene)[-1].record


def test_a_slender_block_buckles_alone_as_beside_another() -> None:
    alone = _column(0).energy
    assert alone < 0.4 * 0.00053375  # the energy of the straight one
    assert _column(1).energy == pytest.approx(alone, rel=1e-8)


def test_load_stepping_follows_a_block_that_buckles_and_nothing_is_lost() -> None:
    """The bifurcation of an elastic column is continuous: only a jump from a saddle farther on would lose energy."""
    stepped = _column(0, LoadStepping())
    assert stepped.certified
    assert stepped.energy == pytest.approx(_column(0).energy, rel=1e-6)
    assert 0 <= stepped.dissipation < 1e-6 * stepped.energy


def test_load_stepping_tells_what_an_arch_loses_that_snaps_through() -> None:
    line = occ.MoveTo(-1, -0.06).LineTo(0, 0.14).LineTo(1, -0.06).LineTo(1, 0).LineTo(0, 0.2).LineTo(-1, 0)
    face = line.Close().Face()
    face.edges.Min(occ.X).name, face.edges.Max(occ.X).name = "left", "right"
    for edge in face.edges:
        if edge.center.y > 0.09:
            edge.name = "top"
    supports, load = (BodySupport("left"), BodySupport("right")), Traction(boundary="top", vector=(0.0, -0.01))
    arch = Body(face, _RUBBER, "arch")
    scene = BodyScene(
        (arch,), supports, loads=(load,), size=0.1, order=2, levels=4, accuracy=inf, strategy=LoadStepping()
    )
    last = simulate(scene)[-1].record
    assert last.certified
    assert last.dissipation > 0.1 * last.energy


def test_one_jump_through_a_beam_is_followed() -> None:
    bodies = (_block("beam", 0.0, 4.0, 0.0, 0.2), _block("punch", 1.8, 0.4, 0.3, 0.4))
    supports = (BodySupport("beam_left"), BodySupport("beam_right"), BodySupport("punch_top", translation=(0.0, -0.6)))
    one, three = (
        simulate(BodyScene(bodies, supports, size=0.2, order=1, levels=levels, accuracy=inf))[-1].record
        for levels in (1, 3)
    )
    assert one.energy > 0
    assert one.energy == pytest.approx(three.energy, rel=1e-8)


def test_a_load_that_nothing_balances_is_a_bad_case() -> None:
    with pytest.raises(CaseError, match="nothing balances it"):
        simulate(
            BodyScene(
                (_block("a", 0.0, 1.0, 0.0, 1.0),),
                loads=(Traction(boundary="a_top", vector=(0.1, 0.0)),),
                size=0.5,
                accuracy=inf,
            )
        )
