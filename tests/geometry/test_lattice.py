"""The lattice: neighbours, three-cell corners and hull walls, each counted in a second way."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from ngcell.contact.pairing.facing import count_corners, find_facing
from ngcell.geometry.lattice import Lattice, hexagonal_lattice
from tests.tissues import small_tissue

PATCHES = [(5, 7), (3, 4), (2, 2), (1, 3), (4, 1)]


def touching_pairs(lattice: Lattice) -> set[tuple[int, int]]:
    """Pairs of cells whose centres are two apothems apart: known from distances alone."""
    apart = np.linalg.norm(lattice.centres[:, None] - lattice.centres, axis=2)
    return {(int(a), int(b)) for a, b in np.argwhere(np.isclose(apart, 2 * lattice.apothem)) if a < b}


def mutual_triples(pairs: set[tuple[int, int]]) -> int:
    """Number of three cells that all touch each other."""
    cells = sorted({cell for pair in pairs for cell in pair})
    return sum({(a, b), (a, c), (b, c)} <= pairs for a, b, c in combinations(cells, 3))


@pytest.mark.parametrize("pointy", [True, False])
@pytest.mark.parametrize(("rows", "cols"), PATCHES)
def test_facing_pairs_and_corners_are_those_of_the_neighbours(rows, cols, pointy):
    tissue = small_tissue(rows, cols, pointy=pointy, order=1)
    pairs = touching_pairs(tissue.lattice)
    found = find_facing(tissue.walls, 1e-3)
    assert {(int(a), int(b)) for a, b in found.pairs} == pairs
    assert count_corners(tissue.walls) == mutual_triples(pairs)


@pytest.mark.parametrize("pointy", [True, False])
def test_the_patch_of_the_source_has_82_pairs_and_48_corners(pointy):
    tissue = small_tissue(5, 7, pointy=pointy, order=1)
    assert len(find_facing(tissue.walls, 1e-3).pairs) == 82
    assert count_corners(tissue.walls) == 48


def test_every_facing_pair_has_the_whole_wall_from_both_sides_and_half_of_it_is_middle():
    tissue = small_tissue(3, 3, edges=4)
    facing = find_facing(tissue.walls, 1e-3)
    length = np.bincount(facing.pair, weights=facing.weight)
    middle = np.bincount(facing.pair, weights=facing.weight * facing.is_middle)
    np.testing.assert_allclose(length, 2.0, rtol=1e-12)
    np.testing.assert_allclose(middle, 1.0, rtol=0.2)


@pytest.mark.parametrize("pointy", [True, False])
def test_neighbours_see_each_other_through_opposite_walls(pointy):
    lattice = hexagonal_lattice(4, 3, side=0.7, pointy=pointy)
    cell, wall = np.nonzero(lattice.neighbours >= 0)
    assert (lattice.neighbours[lattice.neighbours[cell, wall], (wall + 3) % 6] == cell).all()


@pytest.mark.parametrize("pointy", [True, False])
def test_the_rotation_of_corners_and_normals_is_anticlockwise_and_outward(pointy):
    lattice = hexagonal_lattice(1, 1, side=2.0, pointy=pointy)
    ahead = np.roll(lattice.corners, -1, axis=0)
    middle = (lattice.corners + ahead) / 2
    np.testing.assert_allclose(middle, lattice.apothem * lattice.normals, atol=1e-14)
    x, y = lattice.corners.T
    assert (x * ahead[:, 1] - y * ahead[:, 0] > 0).all()
    assert np.isclose(lattice.corners[:, 1].max(), 2.0 if pointy else lattice.apothem)


@pytest.mark.parametrize(("rows", "cols"), [(5, 7), (1, 3), (2, 4)])
def test_plates_of_pointy_rows_hold_two_walls_of_each_cell(rows, cols):
    lattice = hexagonal_lattice(rows, cols, side=1.0, pointy=True)
    for row, upward in ((0, -1), (rows - 1, 1)):
        held = lattice.hull_walls(row, upward)
        assert (held.sum(1) == 2 * (lattice.row_of_cell == row)).all()


def test_plates_of_flat_rows_hold_three_walls_of_protruding_cells_and_one_of_the_others():
    lattice = hexagonal_lattice(5, 7, side=1.0, pointy=False)
    bottom, top = lattice.hull_walls(0, -1).sum(1), lattice.hull_walls(4, 1).sum(1)
    assert bottom[:7].tolist() == [3, 1, 3, 1, 3, 1, 3]
    # At the top the moved columns protrude; the outermost cells add the wall that looks past the patch.
    assert top[-7:].tolist() == [2, 3, 1, 3, 1, 3, 2]
    assert bottom[7:].sum() == top[:-7].sum() == 0


def test_hull_walls_close_around_the_patch():
    lattice = hexagonal_lattice(3, 4, side=1.0, pointy=True)
    hull = lattice.neighbours < 0
    outward = np.einsum("cw,wd->d", hull, lattice.normals)
    np.testing.assert_allclose(outward, 0, atol=1e-12)  # a closed curve: normals times lengths add to zero
    assert hull.sum() == 6 * 12 - 2 * len(touching_pairs(lattice))
