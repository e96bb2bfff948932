"""What bodies cover twice, by areas, against shapes whose overlaps are known."""

from __future__ import annotations

import numpy as np
import pytest
from netgen import occ

from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.covered_twice import depth_in_itself, depth_in_others
from ngcell.results.outline_overlap import deepest_overlap_of_faces
from ngcell.results.solid_overlap import deepest_overlap_of_solids


def space_of(*faces: occ.Face, order: int = 2, size: float = 0.5) -> tuple[DisplacementSpace, Surface]:
    bodies = mesh_shapes(list(faces), [f"body{number}" for number in range(len(faces))], order=order, size=size)
    space = DisplacementSpace(bodies, order)
    return space, find_surface(bodies, space.scalar, space.rest)


def rectangle(low: tuple[float, float], high: tuple[float, float]) -> occ.Face:
    return occ.MoveTo(*low).Rectangle(high[0] - low[0], high[1] - low[1]).Face()


def cell(order: int = 2) -> DisplacementSpace:
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    return DisplacementSpace(ring_mesh(lattice.outlines, wall=0.1, radius=0.1, edges=3, layers=1, supports={}), order)


def mapped(space: DisplacementSpace, move) -> np.ndarray:
    """Positions of vertices, moved; straight edges between them."""
    return np.where(space.one > 0, move(space.rest), 0.0)


def test_two_identical_blocks_are_at_the_same_place():
    space, walls = space_of(rectangle((0, 0), (1, 1)), rectangle((0, 0), (1, 1)))
    assert deepest_overlap_of_faces(walls, space, space.rest) < 1e-12  # no point of a wall is inside
    assert depth_in_others(space, walls, space.rest) == pytest.approx(0.5)


def test_coarse_edges_that_cross_between_their_points_are_seen():
    """Bars of one element each: no node of either is inside the other."""
    space, walls = space_of(rectangle((-5, -0.5), (5, 0.5)), rectangle((-0.5, -5), (0.5, 5)), order=1, size=20.0)
    shared = 2 * 1.0 / 4.0
    assert depth_in_others(space, walls, space.rest) == pytest.approx(shared)


@pytest.mark.parametrize("gap", [0.0, 1e-3, 0.2])
def test_blocks_that_touch_or_are_apart_share_nothing(gap):
    space, walls = space_of(rectangle((0, 0), (1, 1)), rectangle((0, 1 + gap), (1, 2)))
    assert depth_in_others(space, walls, space.rest) < 1e-12


@pytest.mark.parametrize("overlap", [1e-6, 1e-3, 0.1])
def test_a_thin_overlap_has_nearly_its_thickness(overlap):
    space, walls = space_of(rectangle((0, 0), (1, 1)), rectangle((0, 1 - overlap), (1, 2)))
    assert depth_in_others(space, walls, space.rest) == pytest.approx(overlap / (1 + overlap), rel=1e-6)
    assert depth_in_others(space, walls, space.rest) <= deepest_overlap_of_faces(walls, space, space.rest) + 1e-12


def test_a_body_that_is_what_it_should_be_is_not_in_itself():
    for order in (1, 2, 3):
        space = cell(order)
        assert depth_in_itself(space, space.rest)[0] == 0
        turned = space.affine(np.array([[0.6, -0.8], [0.8, 0.6]]), np.array([3.0, 1.0]))
        assert depth_in_itself(space, turned)[0] == 0


def test_walls_of_a_cell_that_pass_each_other_cover_twice():
    """Squeezed flat, the upper wall of a cell goes through the lower one."""
    space = cell()
    squeezed = mapped(
        space, lambda at: np.array([at[0], at[1] - 1.2 * np.sign(at[1]) * np.minimum(np.abs(at[1]) / 0.5, 1)])
    )
    depth, body = depth_in_itself(space, squeezed)
    assert depth > 0.02 and body == 0


def test_a_body_inside_out_covers_itself_with_all_of_its_area():
    space, _ = space_of(rectangle((0, 0), (1, 1)))
    mirrored = space.affine(np.diag([-1.0, 1.0]), np.zeros(2))
    assert depth_in_itself(space, mirrored)[0] == pytest.approx(0.5)


def test_a_lumen_inside_out_is_seen():
    """The lumen's left side goes to the right and its right side to the left, the outer wall stays."""
    space = cell()
    inner = np.linalg.norm(space.rest, axis=0) < 0.92
    turned_over = mapped(space, lambda at: np.where(inner, np.array([-at[0], at[1]]), at))
    assert depth_in_itself(space, mapped(space, lambda at: at))[0] == 0
    assert depth_in_itself(space, turned_over)[0] > 0.1


def test_a_strip_bent_around_until_its_ends_pass_covers_its_overlap_twice():
    """A strip of length 10 and thickness 0.2 on a circle of radius 1.5: its ends overlap by 10 - 2 pi 1.5."""
    space, _ = space_of(rectangle((0, -0.1), (10, 0.1)), order=1, size=0.1)
    x, y = space.rest
    positions = np.where(space.one > 0, (1.5 - y) * np.array([np.cos(x / 1.5), np.sin(x / 1.5)]), 0.0)
    length = 10 - 2 * np.pi * 1.5
    depth, _ = depth_in_itself(space, positions)
    assert depth == pytest.approx(2 * 0.2 * length / (2 * (0.2 + length)), rel=0.05)


def test_two_identical_solids_are_at_the_same_place():
    boxes = [occ.Box((0, 0, 0), (1, 1, 1)) for _ in range(2)]
    bodies = mesh_shapes(boxes, ["one", "two"], order=1, size=0.6)
    space = DisplacementSpace(bodies, 1)
    walls = find_surface(bodies, space.scalar, space.rest)
    assert deepest_overlap_of_solids(walls, space, space.rest) > 0.1
