"""Elements in lumens are the right way out at rest, whatever the outline."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ngcell.errors import NgcellError
from ngcell.geometry.filling import are_three_quadrangles, smallest_sines
from ngcell.geometry.tissues.brick import Brick
from ngcell.geometry.tissues.perturbed import Perturbed
from ngcell.geometry.tissues.voronoi import Voronoi
from ngcell.scene import MeshChoice

TISSUES: dict[str, Any] = {"brick": Brick, "voronoi": Voronoi, "perturbed": Perturbed}


def smallest_sine(kind: str, grading: int, **keys: Any) -> float:
    """Return the smallest sine of the angles of elements in lumens, negative where one is folded."""
    mesh = TISSUES[kind](**keys).mesh("plates", MeshChoice(order=1, grading=grading), None, filled=True)
    points = np.array([vertex.point for vertex in mesh.mesh.vertices])
    quads = [[vertex.nr for vertex in element.vertices] for element in mesh.mesh.Elements()]
    return float(smallest_sines(points[np.array(quads)[mesh.is_filling]]).min())


@pytest.mark.parametrize("grading", [0, 1, 2])
@pytest.mark.parametrize("radius", [0.0, 0.5, 1.0, 5.0])
@pytest.mark.parametrize("wall", [0.02, 0.05])
def test_lumens_beside_rounded_corners_are_not_folded(wall, radius, grading):
    sizes = [{"rows": 2, "cols": 2, "aspect": aspect} for aspect in (0.5, 1.0, 2.0)]
    scenes = [("brick", size) for size in sizes]
    scenes += [("voronoi", {"cells": 6, "extent": [3.0, 3.0], "seed": seed}) for seed in range(4)]
    found = []
    for kind, keys in scenes:
        try:
            found.append(smallest_sine(kind, grading, wall=wall, corner_radius=radius * wall, **keys))
        except NgcellError as error:  # a radius that a short side has no room for
            assert "round corners" in str(error)
    assert found and min(found) > 0


@pytest.mark.parametrize("spread", [0.3, 0.4, 0.49])
def test_irregular_hexagons_are_not_folded(spread):
    """Three quadrangles fold in one tissue of 60 at 0.3, in every second at 0.49."""
    found, nested = [], []
    for seed in range(20):
        keys = {"rows": 3, "cols": 3, "wall": 0.05, "spread": spread, "seed": seed}
        try:
            tissue = Perturbed(**keys)
        except ValueError as error:  # walls that close a lumen
            assert "spread" in str(error)
            continue
        nested.append(tissue.nests_lumens)
        found += [smallest_sine("perturbed", grading, **keys) for grading in (0, 1)]
    assert found and min(found) > 0
    assert spread < 0.4 or not all(nested)


def test_a_hexagon_is_three_quadrangles_where_these_are_convex():
    angle = np.pi / 3 * np.arange(6)
    regular = np.column_stack([np.cos(angle), np.sin(angle)])
    dented = regular.copy()
    dented[1] *= 0.2
    assert are_three_quadrangles(np.array([regular, dented])).tolist() == [True, False]
