"""Pictures of a thousand cells: walls keep their colours, marks their cells, and numbers can be read."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.image import imread

from ngcell.export import draw_debonding, draw_layout, draw_tissue
from ngcell.results.layout import Layout
from ngcell.results.snapshot import Grid, Snapshot

_FRAME = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_QUADS = np.array([[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)])
_RING = np.vstack([_FRAME, 0.5 + 0.8 * (_FRAME - 0.5)])


def rings(side: int) -> Grid:
    """Return `side` times `side` unit rings side by side, sheared; the first is held by nothing."""
    count = side * side
    corner = np.column_stack([np.arange(count) % side, np.arange(count) // side])
    points = np.zeros((8 * count, 3))
    points[:, :2] = (_RING + corner[:, None]).reshape(-1, 2)
    quads = (_QUADS + 8 * np.arange(count)[:, None, None]).reshape(-1, 4)
    displacement = np.column_stack([0.1 * points[:, 1], 0 * points[:, :2]])
    owner = np.repeat(np.arange(count), 4)
    free = (owner == 0).astype(np.int64)
    return Grid(points, quads, 9, {"displacement": displacement}, {"cell_id": owner, "free": free})


def layout(side: int) -> Layout:
    grid = rings(side)
    corners = grid.points[grid.cells, :2]
    owner = grid.cell_data["cell_id"]
    walls = {"wall": np.stack([corners[:, 0], corners[:, 1]], axis=1)}
    return Layout(list(corners), owner, np.zeros(len(owner), dtype=bool), walls, ("wall",), ())


def coloured_share(path) -> float:
    """Return what share of the pixels that are not pale has a colour."""
    picture = imread(path)[..., :3]
    picture = picture[:, : int(0.86 * picture.shape[1])]  # without the colour bar
    seen = picture[picture.min(2) < 0.6]
    return float(np.mean(np.ptp(seen, axis=1) > 0.15))


@pytest.mark.parametrize("side", [6, 32])
def test_outlines_leave_walls_their_colours(tmp_path, side):
    snapshot = Snapshot(0, 1.0, 0.1 * side, rings(side), rings(side))
    assert coloured_share(draw_tissue(snapshot, tmp_path / "tissue.png", title="", certified=True)) > 0.6


def test_pictures_grow_with_the_number_of_cells_as_far_as_it_pays(tmp_path):
    def width(side: int) -> int:
        grid = rings(side)
        picture = draw_tissue(Snapshot(0, 1.0, 1.0, grid, grid), tmp_path / "a.png", title="", certified=True)
        return int(imread(picture).shape[1])

    few, some, many, most = (width(side) for side in (2, 6, 32, 60))
    assert few == some == 1290 and many > 1.5 * few and most == 2 * few


def test_cells_too_small_for_dashes_have_a_colour_where_nothing_holds_them(tmp_path):
    def orange(side: int) -> int:
        grid = rings(side)
        picture = draw_tissue(Snapshot(0, 1.0, 1.0, grid, grid), tmp_path / "a.png", title="", certified=True)
        red, green, blue = np.moveaxis(imread(picture)[..., :3], 2, 0)
        return int(((red > 0.9) & (green > 0.6) & (green < 0.8) & (blue < 0.5)).sum())

    assert orange(6) == 0 and orange(32) > 500


def test_walls_and_marks_of_the_plan_leave_room_between_them(tmp_path, make_record):
    side, grid = 32, rings(32)
    pairs = [(cell, cell + 1, 0.3) for cell in range(side * side - 1) if cell % side != side - 1]
    history = [make_record(step) for step in range(1, 4)]
    ends = ["burst"] * side**2
    picture = imread(draw_debonding(history, pairs, grid, tmp_path / "a.png", certified=True, ends=ends))[..., :3]
    rows, columns = (slice(int(low * size), int(high * size)) for low, high, size in (
        (0.3, 0.7, picture.shape[0]), (0.55, 0.8, picture.shape[1])))  # fmt: skip
    plan = picture[rows, columns]
    red, green, blue = np.moveaxis(plan, 2, 0)
    mark = (red > 0.6) & (green < 0.3) & (blue < 0.2)
    assert np.mean(plan.min(2) > 0.95) > 0.5 and np.mean(mark) > 0.05


def test_numbers_are_as_large_as_the_cell_allows(tmp_path, monkeypatch):
    """Those of a thousand cells are written, smaller than those of a few; those of many more are left out."""
    from matplotlib.axes import Axes

    heights = []
    monkeypatch.setattr(Axes, "text", lambda *_, fontsize, **__: heights.append(fontsize))
    written = {}
    for side in (6, 32, 70):
        heights.clear()
        draw_layout(layout(side), tmp_path / "a.png")
        written[side] = len(heights), *sorted(set(heights))
    assert written[6] == (36, 8) and written[70] == (0,)
    count, height = written[32]
    assert count == 1024 and 4 < height < 6
