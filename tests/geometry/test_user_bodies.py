"""User-defined bodies are what their sizes say, or refused in words."""

from __future__ import annotations

from math import pi

import pytest

from ngcell import Block, Disc, GeometryError, PolygonTissue, Ring
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.shapes import mesh_shapes
from tests.tissues import LAW

GIVEN = {"name": "a", "material": LAW}


@pytest.mark.parametrize("part", ["whole", "upper", "left", "lower-right"])
@pytest.mark.parametrize(("size", "away"), [(1.0, 0.0), (1e-3, 0.0), (1.0, 1e4), (2e-6, 0.0), (1.0, 1e6), (1e3, 1e6)])
def test_a_body_has_its_area_and_its_sides_or_is_refused(part, size, away):
    centre = (away, -0.7 * away)
    share = {"whole": 1, "upper": 2, "left": 2, "lower-right": 4}[part]
    low, high = centre, (centre[0] + 3 * size, centre[1] + 2 * size)
    bodies = [
        (Disc(**GIVEN, radius=size, centre=centre, part=part), pi * size**2 / share),
        (Ring(**GIVEN, inner=size, outer=1.2 * size, centre=centre, part=part), 0.44 * pi * size**2 / share),
        (Block(**GIVEN, low=low, high=high), 6 * size**2),
    ]
    for body, area in bodies:
        try:
            face = body.face
        except GeometryError as error:
            assert size < 1e-4 or away > 1e5
            assert "body a is too small, or too far" in str(error)
            continue
        assert face.mass == pytest.approx(area, rel=1e-6)
        assert {edge.name for edge in face.edges} == set(body.boundaries)
        if not away and size == 1:
            assert set(mesh_shapes([face], ["a"], order=2).mesh.GetBoundaries()) == set(body.boundaries)


@pytest.mark.parametrize("side", [1.0, 1e-3, 3e-6, 3e-7])
def test_polygons_of_a_script_have_their_areas_or_are_refused(side):
    lattice = hexagonal_lattice(1, 2, side=side, pointy=True)
    hexagons = [lattice.outlines.corners[lattice.outlines.cell == cell].tolist() for cell in range(2)]
    tissue = PolygonTissue(hexagons, wall=0.1 * side)
    try:
        faces = tissue.faces
    except GeometryError as error:
        assert side < 1e-4 and "of its area" in str(error)
        return
    area = 1.5 * 3**0.5 * (1 - (1 - 0.2 / 3**0.5) ** 2) * side**2
    assert [face.mass for face in faces] == pytest.approx([area, area], rel=1e-6)
