"""Loads on solids: forces that are the derivative of a potential, and the volume that a pressure sweeps."""

from __future__ import annotations

from math import pi

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.errors import CaseError
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene import BodyForce, Pressure, Traction

STILL = np.zeros((3, 3))


def space_of(solid: occ.TopoDS_Shape, order: int = 2) -> DisplacementSpace:
    return DisplacementSpace(mesh_shapes([solid], ["body"], order=order, size=0.6), order)


def cube() -> occ.Solid:
    solid = occ.Box((0, 0, 0), (1, 1, 1)).solids[0]
    for axis in "XYZ":
        solid.faces.Min(getattr(occ, axis)).name = f"{axis.lower()}0"
        solid.faces.Max(getattr(occ, axis)).name = f"{axis.lower()}1"
    return solid


def held(space: DisplacementSpace, *planes: str) -> PrescribedMotion:
    components = [tuple(axis == plane[0] for axis in "xyz") for plane in planes]
    supports = [Support(plane, STILL, np.zeros(3), which) for plane, which in zip(planes, components, strict=True)]
    return PrescribedMotion(space, supports)


def smooth(space: DisplacementSpace, motion: PrescribedMotion, amplitude: float, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    x, y, z = space.rest
    terms = np.array([space.one, x, y, z, x * y, y * z * space.one, 0.1 * random.standard_normal(space.size)])
    return motion.imposed(amplitude * (random.standard_normal((3, len(terms))) @ terms).ravel(), 0.0)


ALL = [
    Pressure(boundary="x1", value=0.7),
    Traction(boundary="y1", vector=(0.1, 0.2, -0.3)),
    BodyForce(body="body", vector=(0.0, 0.3, 0.5)),
]


@pytest.mark.parametrize("order", [1, 2])
def test_forces_and_tangent_are_derivatives_of_the_potential(order):
    """The surface under pressure ends in two planes of symmetry and at two sides that are under the same pressure."""
    space = space_of(cube(), order)
    motion = held(space, "y0", "z0")
    loads = AppliedLoads(
        space,
        [
            *ALL,
            Pressure(boundary="y1", value=0.7),
            Pressure(boundary="z1", value=0.7),
            Pressure(boundary="x0", value=0.7),
        ],
        motion,
    )
    loads.apply(0.8)
    at, way, step = smooth(space, motion, 0.1, 1), smooth(space, motion, 1.0, 2), 1e-4
    rise = (loads.potential(at + step * way) - loads.potential(at - step * way)) / (2 * step)
    assert rise == pytest.approx(loads.gradient(space.configuration(at)) @ way, rel=1e-7)
    change = (
        loads.gradient(space.configuration(at + step * way)) - loads.gradient(space.configuration(at - step * way))
    ) / (2 * step)
    free = ~motion.fixed.ravel()
    bent = loads.form.tangent(at) @ way
    np.testing.assert_allclose(change[free], bent[free], atol=1e-7 * np.abs(bent).max())


def test_pressure_on_a_closed_surface_sweeps_the_change_of_volume():
    space = space_of(occ.Sphere((0.3, 0, 0), 1.0))
    motion = held(space)
    loads = AppliedLoads(space, [Pressure(boundary="body_outline", value=1.0)], motion)
    loads.apply(1.0)
    at = smooth(space, motion, 0.1, 4)
    gradient = ngsolve.Id(3) + ngsolve.Grad(space.function(at))
    volume = ngsolve.Integrate(ngsolve.Det(gradient) - 1, space.mesh, order=8)
    assert loads.potential(at) == pytest.approx(volume, rel=1e-6)
    force = loads.gradient(space.configuration(at)).reshape(3, -1)
    np.testing.assert_allclose(force @ space.one, 0, atol=1e-10)


def test_pressure_on_a_half_ball_is_borne_by_its_plane_of_symmetry():
    ball = (occ.Sphere((0, 0, 0), 1.0) * occ.Box((-2, -2, 0), (2, 2, 2))).solids[0]
    ball.faces.Min(occ.Z).name, ball.faces.Max(occ.Z).name = "z0", "rim"
    space = space_of(ball)
    motion = held(space, "z0")
    loads = AppliedLoads(space, [Pressure(boundary="rim", value=2.0)], motion)
    loads.apply(1.0)
    stretched = np.array([1.2, 0.9, 1.1])[:, None] * space.rest - space.rest
    normal_force = -(loads.gradient(space.configuration(stretched.ravel())).reshape(3, -1) @ space.one)
    np.testing.assert_allclose(normal_force, [0, 0, -2.0 * pi * 1.2 * 0.9], atol=2e-2)


@pytest.mark.parametrize("held_planes", [(), ("y0",)])
def test_pressure_whose_rim_is_free_is_refused(held_planes):
    space = space_of(cube())
    with pytest.raises(CaseError, match="pressure: its surface ends at .* where it may move freely; allowed: a rim"):
        AppliedLoads(space, [Pressure(boundary="x1", value=1.0)], held(space, *held_planes))


def test_vectors_have_the_dimension_of_the_bodies():
    space = space_of(cube())
    with pytest.raises(CaseError, match="traction on x1: vector has 2 entries; allowed: 3, since the bodies are sol"):
        AppliedLoads(space, [Traction(boundary="x1", vector=(1.0, 0.0))], held(space))
