"""User-defined bodies as meshes: their sides by name, their area, and what is a wall."""

from __future__ import annotations

from math import pi

import ngsolve
import numpy as np
import pytest

from ngcell.geometry.shapes import mesh_shapes
from ngcell.scene import Block, Disc, MooneyRivlin, Refinement, Ring

MATERIAL = MooneyRivlin(c1=1.0, c2=0.0, bulk_modulus=10.0)
SHARES = {"whole": 1, "right": 2, "left": 2, "upper": 2, "lower": 2, "upper-right": 4, "lower-left": 4}


@pytest.mark.parametrize("part", SHARES)
@pytest.mark.parametrize("centre", [(0.0, 0.0), (3.0, -1.0)])
def test_rings_and_discs_have_their_sides_and_areas(part, centre):
    ring = Ring(name="r", material=MATERIAL, inner=0.5, outer=1.0, centre=centre, part=part)
    disc = Disc(name="d", material=MATERIAL, radius=2.0, centre=centre, part=part)
    for body, area in ((ring, 0.75 * pi), (disc, 4 * pi)):
        bodies = mesh_shapes([body.face], [body.name], order=3, size=0.3)
        assert set(bodies.mesh.GetBoundaries()) == set(body.boundaries)
        assert ngsolve.Integrate(1, bodies.mesh) == pytest.approx(area / SHARES[part], rel=1e-4)
        for cut, coordinate, place in (("x0", ngsolve.x, centre[0]), ("y0", ngsolve.y, centre[1])):
            region = bodies.mesh.Boundaries(f"{body.name}_{cut}")
            away = ngsolve.Integrate((coordinate - place) ** 2, bodies.mesh, definedon=region)
            assert away == pytest.approx(0, abs=1e-12)


def test_circles_of_a_ring_are_told_apart():
    ring = Ring(name="r", material=MATERIAL, inner=0.5, outer=1.0)
    mesh = mesh_shapes([ring.face], ["r"], order=3, size=0.2).mesh
    for side, radius in (("inner", 0.5), ("outer", 1.0)):
        length = ngsolve.Integrate(1, mesh, definedon=mesh.Boundaries(f"r_{side}"))
        assert length == pytest.approx(2 * pi * radius, rel=1e-4)


def test_block_has_its_sides():
    block = Block(name="b", material=MATERIAL, low=(1.0, 2.0), high=(3.0, 7.0), size=0.5)
    mesh = mesh_shapes([block.face], ["b"], order=1, size=5.0).mesh
    lengths = {
        side: ngsolve.Integrate(1, mesh, definedon=mesh.Boundaries(f"b_{side}"))
        for side in ("bottom", "top", "left", "right")
    }
    assert lengths == pytest.approx({"bottom": 2.0, "top": 2.0, "left": 5.0, "right": 5.0})
    assert mesh.ne > 60


def test_untouched_sides_are_no_walls():
    ring = Ring(name="r", material=MATERIAL, inner=0.5, outer=1.0, part="upper-right")
    bodies = mesh_shapes([ring.face], ["r"], order=2, untouched=["r_x0", "r_y0", "r_inner"])
    assert bodies.wall_names == "r_outer"


def test_elements_are_small_where_they_are_refined():
    block = Block(name="b", material=MATERIAL, low=(0.0, 0.0), high=(4.0, 4.0))
    refinement = Refinement(at=(0.0, 0.0), within=0.5, size=0.1)
    mesh = mesh_shapes([block.face], ["b"], order=1, size=2.0, refinements=[refinement]).mesh
    points = np.array([vertex.point for vertex in mesh.vertices])
    on_left = np.sort(points[points[:, 0] < 1e-9, 1])
    steps = np.diff(on_left)
    assert steps[on_left[1:] < 0.5].max() < 0.12
    assert steps.max() > 0.5
