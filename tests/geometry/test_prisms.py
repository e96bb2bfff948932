"""Prisms over a section: volumes, regions, outward faces, and walls that face each other."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.contact.pairing.facing import count_corners, find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_mesh, ring_section
from ngcell.mechanics.space import DisplacementSpace

LATTICE = hexagonal_lattice(2, 2, side=1.0, pointy=True)
CHOICES = {"wall": 0.2, "radius": 0.1, "edges": 2, "layers": 2, "supports": {}}


@pytest.mark.parametrize("filled", [False, True])
def test_prisms_are_their_section_times_the_height(filled):
    flat = ring_mesh(LATTICE.outlines, filled=filled, **CHOICES)
    bodies = prism_mesh(ring_section(LATTICE.outlines, filled=filled, **CHOICES), height=0.7, slices=3)
    area = ngsolve.Integrate(ngsolve.CF(1), flat.mesh)
    assert ngsolve.Integrate(ngsolve.CF(1), bodies.mesh) == pytest.approx(0.7 * area, rel=1e-12)
    assert bodies.mesh.ne == 3 * flat.mesh.ne
    assert set(bodies.mesh.GetBoundaries()) == {*flat.mesh.GetBoundaries(), "upper-end", "lower-end"}
    for name in flat.mesh.GetBoundaries():
        length, surface = (
            ngsolve.Integrate(ngsolve.CF(1), part.mesh.Boundaries(name), ngsolve.BND) for part in (flat, bodies)
        )
        assert surface == pytest.approx(0.7 * length, rel=1e-12)
    np.testing.assert_array_equal(bodies.body_of_element, np.repeat(flat.body_of_element, 3))
    normal, place = ngsolve.specialcf.normal(3), ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z))
    assert ngsolve.Integrate(normal * place, bodies.mesh, ngsolve.BND) == pytest.approx(2.1 * area, rel=1e-12)


def test_walls_of_prisms_face_each_other():
    bodies = prism_mesh(ring_section(LATTICE.outlines, **CHOICES | {"radius": 0.0}), height=0.7, slices=2)
    space = DisplacementSpace(bodies, 2)
    walls = find_surface(bodies, space.scalar, space.rest)
    facing = find_facing(walls, 1e-3)
    assert len(facing.pairs) == 5
    assert facing.weight.sum() == pytest.approx(2 * 5 * 0.7, rel=1e-12)
    assert np.abs(facing.gaps(walls, walls.rest)).max() < 1e-12
    assert count_corners(walls) == 2 * 3
    assert walls.is_loose_side.sum() == 2 * 4 * 12


@pytest.mark.parametrize("filled", [False, True])
def test_closed_prisms_have_end_walls_and_a_closed_lumen(filled):
    section = ring_section(LATTICE.outlines, filled=filled, closed=True, **CHOICES | {"radius": 0.0})
    bodies = prism_mesh(section, height=1.0, slices=2, end_wall=0.15)
    whole, inside = (2 * np.sqrt(3) * apothem**2 for apothem in (LATTICE.apothem, LATTICE.apothem - 0.2))
    walls = 4 * (whole - 0.7 * inside)
    for region, volume in (("cell.*", walls), ("filling", 4 * 0.7 * inside)):
        found = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh.Materials(region)) if filled or region != "filling" else 0
        assert found == pytest.approx(volume if filled or region != "filling" else 0, rel=1e-12)
    flux = ngsolve.specialcf.normal(3) * ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z))
    total = walls + (4 * 0.7 * inside if filled else 0)
    assert ngsolve.Integrate(flux, bodies.mesh, ngsolve.BND) == pytest.approx(3 * total, rel=1e-12)
    assert ngsolve.Integrate(ngsolve.CF(1), bodies.mesh.Boundaries("upper-end"), ngsolve.BND) == pytest.approx(
        4 * whole
    )
    if not filled:
        lumen = ngsolve.Integrate(flux, bodies.mesh.Boundaries("lumen"), ngsolve.BND)
        assert lumen == pytest.approx(-3 * 4 * 0.7 * inside, rel=1e-12)
    assert bodies.thickness == 0.15
    used = np.zeros(bodies.mesh.nv, dtype=bool)
    used[[vertex.nr for element in bodies.mesh.Elements(ngsolve.VOL) for vertex in element.vertices]] = True
    assert used.all()


@pytest.mark.parametrize("end_wall", [None, 0.15])
@pytest.mark.parametrize("filled", [False, True])
def test_layers_are_prisms_of_their_own_that_face_each_other(filled, end_wall):
    sections = [
        ring_section(LATTICE.outlines, filled=filled, closed=end_wall is not None, **CHOICES | {"radius": 0.0})
        for _ in range(3)
    ]
    one = prism_mesh(sections[0], height=0.7, slices=2, end_wall=end_wall)
    bodies = prism_mesh(*sections, height=0.7, slices=2, end_wall=end_wall)
    assert bodies.mesh.nv == 3 * one.mesh.nv
    assert bodies.body_names == tuple(f"cell{cell}" for cell in range(12))
    points = np.array([vertex.point for vertex in bodies.mesh.vertices])
    for element, body in zip(bodies.mesh.Elements(ngsolve.VOL), bodies.body_of_element, strict=True):
        middle = points[[vertex.nr for vertex in element.vertices]].mean(0)
        assert middle[2] // 0.7 == body // 4
        assert np.linalg.norm(LATTICE.centres - middle[:2], axis=1).argmin() == body % 4
        assert element.mat == ("filling" if filled and bodies.is_filling[element.nr] else f"cell{body}")
    normal, place = ngsolve.specialcf.normal(3), ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z))
    volume = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh)
    assert volume == pytest.approx(3 * ngsolve.Integrate(ngsolve.CF(1), one.mesh), rel=1e-12)
    assert ngsolve.Integrate(normal * place, bodies.mesh, ngsolve.BND) == pytest.approx(3 * volume, rel=1e-12)
    end = ngsolve.Integrate(ngsolve.CF(1), one.mesh.Boundaries("upper-end"), ngsolve.BND)
    for region, count in (("upper-end", 1), ("lower-end", 1), ("between", 4)):
        found = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh.Boundaries(region), ngsolve.BND)
        assert found == pytest.approx(count * end, rel=1e-12)
    space = DisplacementSpace(bodies, 2)
    walls = find_surface(bodies, space.scalar, space.rest)
    assert walls.quadrature.weight.sum() == pytest.approx(4 * end + 3 * 4 * 6 * 0.7, rel=1e-12)
    facing = find_facing(walls, 1e-3)
    apart = np.diff(facing.pairs).ravel()
    along, stacked = facing.pairs[apart < 4], facing.pairs[apart == 4]
    assert len(along) == 3 * 5 and (along[:, 0] // 4 == along[:, 1] // 4).all()
    assert stacked.tolist() == [[cell, cell + 4] for cell in range(8)]
    assert len(facing.pairs) == len(along) + len(stacked)
    assert facing.weight.sum() == pytest.approx(2 * (3 * 5 * 0.7 + 2 * end), rel=1e-12)
    assert np.abs(facing.gaps(walls, walls.rest)).max() < 1e-12
