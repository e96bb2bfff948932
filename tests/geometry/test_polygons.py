"""A tissue from own polygons: rings of the wall's thickness, common walls that touch, outer ones by name."""

from __future__ import annotations

from math import inf

import ngsolve
import numpy as np
import pytest

from ngcell import BodyScene, BodySupport, MooneyRivlin, PolygonTissue, simulate
from ngcell.errors import GeometryError
from ngcell.geometry.shapes import mesh_shapes

RUBBER = MooneyRivlin(c1=1.0, c2=0.0, bulk_modulus=100.0)
SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
#: The second is given clockwise, the third has another number of sides.
CELLS = [SQUARE, [(2.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0)], [(0.0, 1.0), (1.0, 1.0), (0.5, 2.0)]]


def test_cells_are_rings_of_the_walls_thickness():
    tissue = PolygonTissue(CELLS, wall=0.1)
    mesh = mesh_shapes(tissue.faces, ["cell0", "cell1", "cell2"], order=1, size=0.1).mesh
    for cell in ("cell0", "cell1"):
        assert ngsolve.Integrate(1, mesh, definedon=mesh.Materials(cell)) == pytest.approx(1 - 0.8**2, rel=1e-9)
    perimeter = 1 + 2 * np.sqrt(1.25)
    shrunk = (
        1 - 0.1 * perimeter
    ) ** 2  # a triangle moved inwards by w keeps the share (1 - w / inradius)^2 of its area
    assert ngsolve.Integrate(1, mesh, definedon=mesh.Materials("cell2")) == pytest.approx((1 - shrunk) / 2, rel=1e-9)


def test_sides_that_no_other_cell_has_are_outer_ones():
    tissue = PolygonTissue(CELLS, wall=0.1)
    mesh = mesh_shapes(tissue.faces, ["cell0", "cell1", "cell2"], order=1, size=0.2).mesh
    lengths = {"cell0_outer": 2, "cell0_wall": 2, "cell1_outer": 3, "cell1_wall": 1, "cell2_outer": 2 * np.sqrt(1.25)}
    for name, length in lengths.items():
        assert ngsolve.Integrate(1, mesh, definedon=mesh.Boundaries(name)) == pytest.approx(length, rel=1e-9)


def test_squeezed_cells_press_on_each_other():
    """Two squares between their outer walls: each is moved by a hundredth towards the other."""
    cells = PolygonTissue(CELLS[:2], wall=0.2)
    moved = [BodySupport("cell0_outer", translation=(0.01, 0.0)), BodySupport("cell1_outer", translation=(-0.01, 0.0))]
    (step,) = simulate(BodyScene(cells.bodies(RUBBER), moved, levels=1, size=0.1, accuracy=inf))
    assert step.record.contact_force > 0
    assert step.record.plate_force_x == pytest.approx(0, abs=1e-3 * step.record.contact_force)


@pytest.mark.parametrize(
    ("polygon", "wall", "says"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], 0.1, "polygon 0: Self-intersection.*allowed: a simple polygon"),
        (SQUARE, 0.5, "leaves no single lumen; allowed: 0 < wall < 0.5"),
        (SQUARE, 0.0, "leaves no single lumen; allowed: 0 < wall < 0.5"),
        (SQUARE[:2], 0.1, "polygon 0: .*allowed: three corners or more"),
        ([*SQUARE, (0.5,)], 0.1, "polygon 0: .*allowed: three corners or more"),
        ([(0, 0), (1, 0), (inf, 1)], 0.1, "polygon 0: .*allowed: three corners or more"),
        ([(0, 0, 0), (1, 0, 0), (1, 1, 0)], 0.1, r"polygon 0: .*\(x, y\) each"),
        ("outline", 0.1, "polygon 0: 'outline'; allowed: three corners or more"),
    ],
)
def test_what_is_no_cell_is_refused(polygon, wall, says):
    with pytest.raises(GeometryError, match=says):
        PolygonTissue([polygon], wall=wall)
