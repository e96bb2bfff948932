"""Tissues from files: polygons as GeoJSON, WKT and tables, label images, and what is wrong with them in one line."""

from __future__ import annotations

import json
import re
from math import inf
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from ngcell import CaseError, LabelImage, Polygons, Tissue, read_case, simulate
from ngcell.errors import GeometryError
from ngcell.geometry.label_images import check_walls_touch, traced_cells
from ngcell.scene import Case
from tests.prisms import MATERIAL

#: A re-entrant cell, one in its corner, and two on top, whose joint lies inside of its long side.
CELLS = [
    [(0, 0), (1, 0), (1, 2), (3, 2), (3, 3), (0, 3)],
    [(1, 0), (3, 0), (3, 2), (1, 2)],
    [(0, 3), (1.6, 3), (1.6, 4.5), (0, 4.5)],
    [(1.6, 3), (3, 3), (3, 4.5), (1.6, 4.5)],
]
SQUARE, ABOVE = CELLS[1], [(1, 2), (3, 2), (3, 4), (1, 4)]
REST = """
[material]
kind = "mooney-rivlin"
c1 = 1.0
c2 = 1.0
bulk_modulus = 100.0
[load]
kind = "plates"
displacement = [0.1, 0.0]
levels = 1
"""


def geojson(cells: list) -> str:
    features = [{"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(cell)} for cell in cells]
    return json.dumps({"type": "FeatureCollection", "features": features})


def table(cells: list) -> str:
    rows = [f"{number},{x},{y}" for number, cell in enumerate(cells) for x, y in cell]
    return "\n".join(["cell,x,y", *rows]) + "\n"


WRITTEN = {
    "cells.geojson": geojson([shapely.Polygon(cell) for cell in CELLS]),
    "cells.wkt": "\n".join(shapely.Polygon(cell).wkt for cell in CELLS) + "\n",
    "all.wkt": shapely.GeometryCollection([shapely.Polygon(cell) for cell in CELLS]).wkt,
    "cells.csv": table(CELLS),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_every_sort_of_file_holds_the_same_cells(tmp_path, name):
    (tmp_path / name).write_text(WRITTEN[name])
    outlines = Polygons(file=str(tmp_path / name), wall=0.1, scale=2.0).outlines
    assert outlines.counts.tolist() == [7, 4, 4, 4]
    np.testing.assert_allclose(outlines.areas, [4 * shapely.Polygon(cell).area for cell in CELLS], rtol=1e-12)
    assert len({(a, b) for a, b in zip(outlines.cell, outlines.neighbours, strict=True) if b > a}) == 5 - 1


def test_paths_are_relative_to_the_case_file(tmp_path, monkeypatch):
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "cells.csv").write_text(WRITTEN["cells.csv"])
    (tmp_path / "other.csv").write_text(table(CELLS[:2]))
    case = '[tissue]\nkind = "polygons"\nfile = "cells.csv"\nwall = 0.1\n'
    (tmp_path / "cases" / "one.toml").write_text(case + REST)
    (tmp_path / "two.toml").write_text('extends = "cases/one.toml"\n')
    monkeypatch.chdir(tmp_path)
    for file in ("cases/one.toml", "two.toml"):
        assert Path(read_case(file).tissue.file) == tmp_path / "cases" / "cells.csv"
    assert read_case("two.toml", ["tissue.file=other.csv"]).tissue.cell_count == 2


def test_polygons_of_hexagons_are_the_honeycomb(tmp_path):
    """The same energy to round-off, though the file's cells begin at other corners."""
    regular = Tissue(rows=2, cols=2, wall=0.1)
    outlines = regular.outlines
    corners = [np.roll(outlines.corners[outlines.cell == cell], cell, axis=0) for cell in range(4)]
    (tmp_path / "hexagons.csv").write_text(table(corners))
    energies = []
    for tissue in (regular, Polygons(file=str(tmp_path / "hexagons.csv"), wall=0.1)):
        load = {"kind": "plates", "displacement": [0.3, 0.0], "levels": 1}
        case = {"tissue": tissue, "material": MATERIAL, "load": load, "accuracy": inf}
        energies.append(simulate(Case.model_validate(case))[-1].record.energy)
    assert energies[1] == pytest.approx(energies[0], rel=1e-8)


def test_corners_that_miss_each_other_are_snapped(tmp_path):
    file = tmp_path / "cells.csv"
    file.write_text(table([SQUARE, [(1.003, 2.004), (2.996, 2), (3, 4), (1, 4)]]))
    with pytest.raises(CaseError, match="cell 0 and cell 1 have a gap of 0.00.*allowed: walls that touch to|overlap"):
        Polygons(file=str(file), wall=0.1)
    outlines = Polygons(file=str(file), wall=0.1, snap=0.01).outlines
    assert (outlines.twins >= 0).sum() == 2


def hexagon_labels(pixels_to_a_side: float) -> np.ndarray:
    """A 3 x 3 honeycomb as pixels: the cell whose centre is nearest, 0 beyond the cells."""
    tissue = Tissue(rows=3, cols=3, wall=0.1)
    centres, side = tissue.lattice.centres + (1, 1.1), 1 / pixels_to_a_side
    x, y = np.meshgrid(*(np.arange(side / 2, extent, side) for extent in (6.3, 5.3)))
    away = np.stack([x, y], axis=-1)[:, :, None] - centres
    beyond = np.max(np.einsum("rcnd,wd->rcnw", away, tissue.lattice.normals), axis=3) > tissue.apothem
    label = np.where(beyond, np.inf, np.linalg.norm(away, axis=3)).argmin(2) + 1
    return np.where(beyond.all(2), 0, label)[::-1]


def test_an_image_of_a_honeycomb_converges_to_it(tmp_path):
    outlines = Tissue(rows=3, cols=3, wall=0.1).outlines
    errors = []
    for pixels in (20, 40, 80):
        file = tmp_path / f"{pixels}.png"
        Image.fromarray(hexagon_labels(pixels).astype(np.uint8)).save(file)
        found = LabelImage(file=str(file), pixel=1 / pixels, wall=0.1).outlines
        assert found.cell_count == 9
        moved = shapely.transform(found.polygons, lambda at: at - (1, 1.1))
        errors.append(shapely.hausdorff_distance(moved, outlines.polygons, densify=0.1).max())
        pairs = {(a, b) for a, b in zip(found.cell, found.neighbours, strict=True) if b > a}
        assert pairs == {(a, b) for a, b in zip(outlines.cell, outlines.neighbours, strict=True) if b > a}
        np.testing.assert_allclose(found.areas, outlines.areas, rtol=2 / pixels)
    assert errors[0] < 2 / 20 and errors[1] < 2 / 40 and errors[2] < 2 / 80


def test_walls_of_images_are_shared_pores_stay_and_corners_of_the_image_are_kept():
    labels = np.repeat(np.repeat([[1, 1, 2], [3, 0, 2], [3, 4, 4]], 12, axis=0), 12, axis=1)
    cells, known = traced_cells(labels, 1.0)
    shapes = [shapely.Polygon(cell) for cell in cells]
    assert known.tolist() == [1, 2, 3, 4]
    whole = shapely.union_all(shapes)
    assert whole.bounds == (0, 0, 36, 36) and whole.exterior.length == pytest.approx(4 * 36)
    assert len(whole.interiors) == 1
    assert sum(shape.area for shape in shapes) == pytest.approx(whole.area, rel=1e-12)
    assert shapely.Polygon(whole.interiors[0]).area == pytest.approx(144, rel=0.02)
    assert shapes[0].contains(shapely.Point(6, 30)) and shapes[3].contains(shapely.Point(30, 6))


IMAGE = np.repeat(np.repeat([[1, 2], [3, 4]], 20, axis=0), 20, axis=1)


def changed(rows: slice, cols: slice, label: int) -> np.ndarray:
    image = IMAGE.copy()
    image[rows, cols] = label
    return image


def with_lines(background: int) -> np.ndarray:
    """Return four irregular cells between lines of background of one pixel, as a watershed leaves them, or none."""
    places = np.array([(20, 20), (70, 25), (25, 75), (75, 80)])
    pixels = np.stack(np.meshgrid(np.arange(100), np.arange(100)), axis=-1)
    labels = np.linalg.norm(pixels[:, :, None] - places, axis=-1).argmin(-1) + 1
    lines = labels.copy()
    lines[:-1][labels[:-1] != labels[1:]] = 0
    lines[:, :-1][labels[:, :-1] != labels[:, 1:]] = 0
    return lines if background else labels


def test_cells_that_touch_are_told_from_cells_between_lines_of_background():
    check_walls_touch(with_lines(0), 4.0)
    blocks = np.repeat(np.repeat([[1, 2], [3, 4]], 12, axis=0), 12, axis=1)
    blocks[11:13, 11:13] = 0  # a pore where four cells meet
    check_walls_touch(blocks, 4.0)
    wide = np.insert(blocks, [12] * 6, 0, axis=0)
    check_walls_touch(wide, 4.0)
    with pytest.raises(GeometryError, match="labels . and . .*; allowed: labels that touch, or pores wider than 8 pix"):
        check_walls_touch(wide, 8.0)


#: What a file holds, the entries beside it, and what the one line about it says.
BAD_FILES = {
    "overlap": ("a.csv", table([SQUARE, [(2, 0), (4, 0), (4, 2), (2, 2)]]), "", "cell 0 and cell 1 overlap by 50 %"),
    "gap": ("a.csv", table([SQUARE, [(1, 2.02), (3, 2.02), (3, 4), (1, 4)]]), "", "have a gap of 0.02 between them"),
    "twice": ("a.csv", table([SQUARE, SQUARE]), "", "cell 0 and cell 1 overlap by 100 %"),
    "crossing": ("a.csv", table([[(0, 0), (2, 2), (2, 0), (0, 2)]]), "", "cell 0: Self-intersection"),
    "two corners": ("a.csv", table([[(0, 0), (2, 2)]]), "", "cell 0 has 2 corners; allowed: three or more"),
    "no number": ("a.csv", "cell,x,y\n0,1,left\n", "", "a.csv:2: x = '1', y = 'left'; allowed: two"),
    "no columns": ("a.csv", "a,b\n1,2\n", "", "does not name cell, x, y"),
    "torn cell": ("a.csv", "cell,x,y\n0,0,0\n1,0,0\n0,1,1\n", "", "a.csv:4: cell 0 again; allowed"),
    "no polygon": ("a.csv", "cell,x,y\n", "", "has no row below its first line; allowed: a row for each corner"),
    "a long field": ("a.csv", "cell,x,y\n0,0," + "1" * 140_000 + "\n", "", "is no CSV .*; allowed: the columns"),
    "curves": ("a.wkt", "CURVEPOLYGON(CIRCULARSTRING(0 0, 4 0, 4 4, 0 4, 0 0))", "", "a.wkt:1: is no WKT"),
    "no GeoJSON": ("a.geojson", "{", "", "is no GeoJSON"),
    "a line": ("a.wkt", "LINESTRING (0 0, 1 1)", "", "cell 0 is a LineString; allowed: a polygon"),
    "no WKT": ("a.wkt", "POLYGON ((0 0, 1 1", "", "a.wkt:1: is no WKT"),
    "hole": (
        "a.geojson",
        geojson([shapely.Polygon(SQUARE).difference(shapely.Point(2, 1).buffer(0.3))]),
        "",
        "cell 0 has a hole; allowed: polygons without holes",
    ),
    "two pieces": (
        "a.geojson",
        geojson([shapely.MultiPolygon([shapely.Polygon(SQUARE), shapely.Polygon(CELLS[2])])]),
        "",
        "cell 0 is of 2 pieces; allowed: one polygon a cell",
    ),
    "another sort": ("a.shp", "", "", "its name ends in none of .geojson"),
    "thick wall": ("a.csv", table([SQUARE, ABOVE]), "wall = 1.0", "its wall of 1 closes .* 0 < wall < 0.97"),
    "sharp corner": (
        "a.csv",
        table([[(0, 0), (4, 0), (0, 0.3)]]),
        "wall = 0.2",
        "cell 0, about .* its wall of 0.2 closes its lumen.*allowed: 0 < wall < 0.1",
    ),
    "round corner": ("a.csv", table([SQUARE]), "corner_radius = 1.9", "round corners of cell 0 meet on one .*< 1.7"),
    "flat end wall": ("a.csv", table([SQUARE]), "end_wall = 0.1", "tissue.end_wall = 0.1: allowed: .*with a height"),
    "unknown key": ("a.csv", table([SQUARE]), "rows = 1", "bad.toml:5: tissue.rows = 1 is unknown; allowed: kind"),
    "no plate": (
        "a.csv",
        table([[(0, 0), (1, 1), (0, 2), (-1, 1)]]),
        "held_within = 0.1",
        "no outer wall lies whole within 0.1 of the tissue's lower edge.*allowed: tissue.held_within >= 1",
    ),
}
BAD_IMAGES = {
    "one label": (np.full((20, 20), 255), "", "one label only, 255; allowed: a number for each cell"),
    "no label": (np.zeros((20, 20)), "", "no label but 0; allowed"),
    "two pieces": (changed(slice(25, 35), slice(5, 15), 2), "", "label 2 is of 2 pieces; allowed"),
    "hole": (changed(slice(25, 35), slice(5, 15), 0), "", "label 3 has a hole; allowed"),
    "speck": (changed(slice(0, 1), slice(0, 2), 9), "", "label 9 has 2 pixels; allowed: 4 or more"),
    "thin cell": (changed(slice(19, 20), slice(5, 15), 9), "tolerance = 3", "has no area left.*: a smaller toleran"),
    "lines between cells": (with_lines(1), "", "labels . and . are separated by a line of background; allowed: labels"),
    "colours": (np.zeros((20, 20, 3)), "", "has 3 channels; allowed: one, a label image"),
    "endless label": (np.where(IMAGE == 4, np.inf, IMAGE).astype(np.float32), "", "pixels that are no whole number"),
    "huge label": (np.where(IMAGE == 4, 1e30, IMAGE).astype(np.float32), "", "pixels that are no whole number"),
    "thick wall": (IMAGE, "wall = 1.0", "cell 0, about .* its wall of 1 closes its lumen.*allowed: 0 < wall < 0.9"),
}


def complaint(tmp_path: Path, kind: str, file: str, entries: str) -> str:
    """Build a case with such a tissue, and return the one line that refuses it."""
    wall = "" if "wall =" in entries.replace("end_wall", "") else "wall = 0.1\n"
    pixel = "pixel = 0.1\n" if kind == "image" else ""
    text = f'[tissue]\nkind = "{kind}"\nfile = "{file}"\n{wall}{pixel}{entries}\n{REST}'
    (tmp_path / "bad.toml").write_text(text)
    with pytest.raises(CaseError) as caught:
        simulate(read_case(tmp_path / "bad.toml"))
    return str(caught.value)


@pytest.mark.parametrize("name", BAD_FILES)
def test_what_a_file_has_wrong_is_one_line(tmp_path, name):
    file, text, entries, says = BAD_FILES[name]
    (tmp_path / file).write_text(text)
    line = complaint(tmp_path, "polygons", file, entries)
    assert "\n" not in line
    assert re.search(says, line), line


@pytest.mark.parametrize("name", BAD_IMAGES)
def test_what_an_image_has_wrong_is_one_line(tmp_path, name):
    image, entries, says = BAD_IMAGES[name]
    file = "a.tif" if image.dtype == np.float32 else "a.png"
    Image.fromarray(image if image.dtype == np.float32 else image.astype(np.uint8)).save(tmp_path / file)
    line = complaint(tmp_path, "image", file, entries)
    assert "\n" not in line
    assert re.search(says, line), line


@pytest.mark.parametrize(("kind", "file"), [("polygons", "none.csv"), ("image", "none.png"), ("image", "bad.toml")])
def test_files_that_are_none_are_named(tmp_path, kind, file):
    line = complaint(tmp_path, kind, file, "")
    assert file in line and ("cannot be read (No such file" in line or "is no image" in line)


def test_sixteen_bits_and_palettes_are_labels_too(tmp_path):
    Image.fromarray(np.where(IMAGE == 4, 40_000, IMAGE).astype(np.uint16)).save(tmp_path / "a.tif")
    palette = Image.fromarray(IMAGE.astype(np.uint8), mode="P")
    palette.putpalette([value for label in range(256) for value in (label, 255 - label, 7)])
    palette.save(tmp_path / "a.png")
    for name in ("a.tif", "a.png"):
        outlines = LabelImage(file=str(tmp_path / name), pixel=0.1, wall=0.1).outlines
        np.testing.assert_allclose(outlines.areas, 4.0, rtol=1e-12)
