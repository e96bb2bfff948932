"""Loads on boundaries: forces that are the derivative of a potential, and the ones that a pressure exerts."""

from __future__ import annotations

from dataclasses import dataclass

import ngsolve
import numpy as np
import pytest
from netgen import occ
from scipy import sparse

from ngcell.errors import CaseError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.applied.dead import DeadLoads, terms_of_loads
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.mechanics.symbolic_sum import SymbolicSum
from ngcell.scene import BodyForce, Pressure, Traction

LAW = MooneyRivlin(c1=0.7, c2=0.3, bulk_modulus=20.0)
STEP = 1e-4
STILL = np.zeros((2, 2))


def ring(inner: float, outer: float) -> occ.TopoDS_Shape:
    return occ.Circle((0, 0), outer).Face() - occ.Circle((0, 0), inner).Face()


def block() -> occ.Face:
    """Of width 2 and height 1, off the origin, with names on all sides."""
    face = occ.Rectangle(2, 1).Face().Move((0.3, 0.2, 0)).faces[0]
    for side, name in (("Y", "roof"), ("X", "right")):
        face.edges.Max(getattr(occ, side)).name = name
        face.edges.Min(getattr(occ, side)).name = {"roof": "floor", "right": "left"}[name]
    return face


@dataclass(frozen=True)
class Loaded:
    """Shapes with supports and loads."""

    bodies: BodyMesh
    space: DisplacementSpace
    motion: PrescribedMotion
    loads: AppliedLoads

    def gradient(self, displacement: np.ndarray, load_factor: float) -> np.ndarray:
        with self.loads.at_factor(load_factor):
            return self.loads.gradient(self.space.configuration(displacement))

    def tangent(self, displacement: np.ndarray, load_factor: float) -> sparse.csr_array:
        with self.loads.at_factor(load_factor):
            return self.loads.form.tangent(displacement)

    def smooth(self, amplitude: float, seed: int) -> np.ndarray:
        """A random displacement that respects supports in place."""
        random = np.random.default_rng(seed)
        x, y = self.space.rest
        one = self.space.one
        terms = np.array([one, x, y, x * y * one, (x * x - y * y) * one, 0.1 * random.standard_normal(len(x))])
        return self.motion.imposed(amplitude * (random.standard_normal((2, len(terms))) @ terms).ravel(), 0.0)


def loaded(shape, loads, supports=(), order: int = 3) -> Loaded:
    bodies = mesh_shapes([shape], ["body"], order=order, size=0.5)
    space = DisplacementSpace(bodies, order)
    motion = PrescribedMotion(space, [Support(*support) for support in supports])
    return Loaded(bodies, space, motion, AppliedLoads(space, loads, motion))


def sliding(name: str, axis: int) -> tuple:
    """A support along whose line a boundary may slide."""
    return name, STILL, np.zeros(2), (axis != 0, axis != 1)


SCENES = {
    "bore": lambda: loaded(ring(0.5, 1.0), [Pressure(boundary="body_hole0", value=0.7)]),
    "rim": lambda: loaded(ring(0.5, 1.0), [Pressure(boundary="body_outline", value=-0.4)], order=2),
    "traction": lambda: loaded(
        block(), [Traction(boundary="right", vector=(0.3, -0.8)), Traction(boundary="roof", vector=(0.1, 0.2))]
    ),
    "places": lambda: loaded(
        block(),
        [
            Traction(boundary="right", vector=lambda x, y: (0.3 * x * y, -0.8)),
            BodyForce(body="body", vector=lambda x, y: (0.2, ngsolve.sin(x) * y)),
        ],
    ),
    "held": lambda: loaded(block(), [Pressure(boundary="roof", value=0.7)], [("left|right", STILL, np.zeros(2))]),
    "sliding": lambda: loaded(
        block(),
        [Pressure(boundary="roof", value=0.7), Traction(boundary="roof", vector=(0.2, 0.0))],
        [sliding("left|right", 1)],
    ),
    "around a corner": lambda: loaded(
        block(),
        [Pressure(boundary="roof", value=0.7), Pressure(boundary="right", value=0.7)],
        [sliding("left", 1), sliding("floor", 0)],
    ),
}


@pytest.fixture(params=SCENES)
def scene(request) -> Loaded:
    return SCENES[request.param]()


def test_forces_and_tangent_are_derivatives_of_the_potential(scene):
    """Central differences, in directions that the supports leave free; the potential is quadratic."""
    loads, free = scene.loads, ~scene.motion.fixed.ravel()
    at, way = scene.smooth(0.2, 1), scene.smooth(1.0, 2) * free
    gradient, tangent = scene.gradient(at, 0.6), scene.tangent(at, 0.6)
    rise = loads.potential(at + STEP * way, 0.6) - loads.potential(at - STEP * way, 0.6)
    assert rise / (2 * STEP) == pytest.approx(gradient @ way, rel=1e-9)
    bent = (scene.gradient(at + STEP * way, 0.6) - scene.gradient(at - STEP * way, 0.6)) / (2 * STEP)
    np.testing.assert_allclose(bent[free], (tangent @ way)[free], atol=1e-9)
    assert abs(tangent - tangent.T).max() < 1e-12
    assert loads.potential(np.zeros_like(at), 1.0) == 0
    np.testing.assert_allclose(scene.gradient(at, 0.6), 0.6 * scene.gradient(at, 1.0), rtol=0, atol=1e-14)


def test_loads_that_depend_on_the_place_do_the_work_of_their_integrals():
    loads = [
        BodyForce(body="body", vector=lambda x, y: (x**2, 3.0)),
        Traction(boundary="right", vector=lambda x, y: (0.0, y)),
    ]
    scene = loaded(block(), loads, order=1)
    translation = np.repeat([0.5, -2.0], scene.space.size) * np.tile(scene.space.one, 2)
    area_x = (2.3**3 - 0.3**3) / 3
    side_y = (1.2**2 - 0.2**2) / 2
    work = 0.5 * area_x - 2.0 * (3.0 * 2.0 + side_y)
    assert scene.loads.potential(translation, 1.0) == pytest.approx(-work, rel=1e-12)


def test_dead_loads_that_depend_on_the_place_are_integrated_once_to_the_same_potential():
    scene = SCENES["places"]()
    given = [
        Pressure(boundary="roof", value=0.7),
        Traction(boundary="right", vector=lambda x, y: (0.3 * x * y, -0.8)),
        BodyForce(body="body", vector=lambda x, y: (0.2, ngsolve.sin(x) * y)),
    ]
    held = PrescribedMotion(scene.space, [Support("left|right", STILL, np.zeros(2))])
    pressed, dead = terms_of_loads(scene.space, given, held)
    assert (type(pressed), type(dead)) == (AppliedLoads, DeadLoads)
    at = scene.space.configuration(scene.smooth(0.2, 1))
    dead.apply(0.6)
    with scene.loads.at_factor(0.6):
        np.testing.assert_allclose(dead.gradient(at), scene.loads.gradient(at), rtol=0, atol=1e-14)
        assert dead.value(at) == dead.unstored(at) == pytest.approx(scene.loads.value(at), rel=1e-12)
    assert dead.drive(at, 0.6).potential == pytest.approx(scene.loads.drive(at, 0.6).potential, rel=1e-12)
    assert terms_of_loads(scene.space, [], held) == ()
    with pytest.raises(CaseError, match="vector"):
        terms_of_loads(scene.space, [Traction(boundary="right", vector=lambda x, y: (x,))], held)


def test_a_sum_adds_the_potential_at_the_applied_load_factor(scene):
    alone = BodyEnergy(scene.space, [LAW])
    total = SymbolicSum([alone, scene.loads])
    at, way = scene.smooth(0.05, 3), scene.smooth(1.0, 4)
    here = scene.space.configuration(at)
    for factor in (0.0, 0.6, 1.0):
        scene.loads.apply(factor)
        potential = scene.loads.potential(at, factor)
        assert total.unstored(here) == pytest.approx(potential, rel=1e-13)
        assert total.value(here) == pytest.approx(alone.value(here) + potential, rel=1e-12)
        gradient = alone.gradient(here) + scene.gradient(at, factor)
        np.testing.assert_allclose(total.gradient(here), gradient, atol=1e-11)
        bent = alone.form.tangent(at) @ way + scene.tangent(at, factor) @ way
        np.testing.assert_allclose(total.form.tangent(at) @ way, bent, atol=1e-9)
    assert alone.unstored(here) == 0.0


@pytest.mark.parametrize("name", SCENES)
def test_forces_are_the_pressure_on_the_deformed_line(name):
    """Virtual work of ``-p n`` on the deformed line, for any virtual displacement, those of supports included."""
    scene = SCENES[name]()
    at, way = scene.smooth(0.2, 1), np.random.default_rng(5).standard_normal(scene.space.unknowns)
    mesh, work = scene.bodies.mesh, 0.0
    u, v = scene.space.function(at), scene.space.function(way)
    centre = (0.0, 0.0) if name in ("bore", "rim") else (1.3, 0.7)
    away = ngsolve.CF((ngsolve.x - centre[0], ngsolve.y - centre[1])) * ngsolve.specialcf.normal(2)
    normal = (-1 if name == "bore" else 1) * ngsolve.IfPos(away, 1, -1) * ngsolve.specialcf.normal(2)
    gradient = ngsolve.Grad(u)
    cofactor = ngsolve.CF((1 + gradient[1, 1], -gradient[1, 0], -gradient[0, 1], 1 + gradient[0, 0]), dims=(2, 2))
    for load in scene.loads._loads:
        if isinstance(load, Pressure):
            force = -load.value * cofactor * normal
        else:
            force = ngsolve.CF(load.vector(ngsolve.x, ngsolve.y) if callable(load.vector) else load.vector)
        if isinstance(load, BodyForce):
            there = ngsolve.dx(definedon=mesh.Materials(load.body), bonus_intorder=6)
        else:
            there = ngsolve.ds(skeleton=True, definedon=mesh.Boundaries(load.boundary), bonus_intorder=6)
        work += ngsolve.Integrate(force * v * there, mesh)
    assert -scene.gradient(at, 1.0) @ way == pytest.approx(work, rel=1e-9)


def test_a_closed_line_is_pressed_nowhere_and_a_pressure_presses_on_the_body():
    scene = SCENES["bore"]()
    at = scene.smooth(0.2, 1)
    force = scene.gradient(at, 1.0).reshape(2, -1)
    x, y = scene.space.rest + at.reshape(2, -1)
    np.testing.assert_allclose(force @ scene.space.one, 0, atol=1e-12)
    assert x @ force[1] - y @ force[0] == pytest.approx(0, abs=1e-12)
    swollen = scene.space.affine(0.1 * np.eye(2), np.zeros(2)).ravel()
    assert scene.loads.potential(swollen, 1.0) == pytest.approx(-0.7 * np.pi * 0.25 * (1.1**2 - 1), rel=1e-3)


@pytest.mark.parametrize(
    "supports",
    [
        [],
        [("right", STILL, np.zeros(2))],
        [sliding("left|right", 1), ("right", STILL, np.array([0.1, 0.0]), (True, False))],
    ],
    ids=["both free", "one free", "sliding along a support that moves"],
)
def test_a_pressure_with_a_free_end_is_refused(supports):
    with pytest.raises(CaseError, match=r"its line ends at \(.*\), which may move freely; allowed: an end that is"):
        loaded(block(), [Pressure(boundary="roof", value=1.0)], supports)
    loaded(block(), [Traction(boundary="roof", vector=(0.0, 1.0))], supports)


def test_held_ends_may_move_with_their_supports():
    scene = loaded(block(), [Pressure(boundary="roof", value=1.0)], [("left|right", STILL, np.array([0.1, 0.2]))])
    assert scene.loads.potential(np.zeros(scene.space.unknowns), 1.0) == 0
