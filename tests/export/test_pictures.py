import subprocess
import sys
from dataclasses import replace

import ngsolve
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread

from ngcell.errors import OutputError
from ngcell.export import SnapshotSeries, curves, draw_curves, draw_debonding, draw_tissue, picture, show, write_summary
from ngcell.export.outline import cell_loops, planar_view
from ngcell.export.solid_picture import _below, _moved
from ngcell.results.patterns import pattern_of
from ngcell.results.snapshot import Grid, Snapshot


def red_share(path):
    red, green, blue = (imread(path)[..., channel] for channel in range(3))
    return np.mean((red > 0.6) & (green < 0.45) & (blue < 0.45))


def test_the_picture_is_not_blank_and_follows_the_data(tmp_path, make_snapshot):
    near = imread(draw_tissue(make_snapshot(1, 0.05), tmp_path / "near.png", title="near", certified=True))
    far = imread(draw_tissue(make_snapshot(1, 0.4), tmp_path / "far.png", title="near", certified=True))
    assert min(near.shape[:2]) > 400
    assert near[..., :3].std() > 0.05
    assert near.shape != far.shape or np.abs(near - far).max() > 0.2


def test_an_open_gap_is_white(tmp_path, make_snapshot):
    picture = imread(draw_tissue(make_snapshot(1, 0.5), tmp_path / "gap.png", title="", certified=True))
    walls = np.flatnonzero((picture[picture.shape[0] // 2, :, :3] < 0.8).any(axis=1))
    between = picture[picture.shape[0] // 2, :, :3].min(axis=1) == 1.0
    assert between[walls[0] : walls[-1]].sum() > 50


def test_an_uncertified_picture_says_so(tmp_path, make_snapshot, make_record):
    history = [make_record(step, 0.01 * step**2) for step in range(8)]
    for draw in (
        lambda path, certified: draw_tissue(make_snapshot(1), path, title="", certified=certified),
        lambda path, certified: draw_curves(history, path, certified=certified),
    ):
        good, bad = draw(tmp_path / "good.png", True), draw(tmp_path / "bad.png", False)
        assert red_share(bad) > red_share(good) + 0.01


def test_the_curves_follow_the_data_and_show_the_onset(tmp_path, make_record):
    slow = [make_record(step, 0.01 * step) for step in range(8)]
    fast = [make_record(step, 0.01 * step**2) for step in range(8)]
    pictures = [
        imread(draw_curves(slow, tmp_path / "slow.png", certified=True)),
        imread(draw_curves(fast, tmp_path / "fast.png", certified=True)),
        imread(draw_curves(fast, tmp_path / "onset.png", certified=True, onset=0.35)),
    ]
    assert pictures[0][..., :3].std() > 0.05
    for one, other in zip(pictures, pictures[1:], strict=False):
        assert np.mean(np.abs(one - other) > 0.1) > 1e-3


def test_a_history_without_load_or_contact_can_be_drawn(tmp_path, make_record):
    record = make_record(0, gap=0.0, phase="tied")
    assert draw_curves([record], tmp_path / "gap.png", certified=True).exists()


def test_curves_are_told_apart_without_colour(tmp_path, make_record, monkeypatch):
    drawn = []
    monkeypatch.setattr(curves, "save_png", lambda figure, path: drawn.append(figure))
    history = [make_record(step, free_largest_gap=0.1, free_mean_gap=0.05) for step in range(3)]
    draw_curves(history, tmp_path / "gap.png", certified=True)
    looks = [(line.get_linestyle(), line.get_marker()) for line in drawn[0].axes[0].lines]
    assert len(looks) == len(set(looks)) == 4


def test_a_long_title_stays_within_the_picture(tmp_path, make_snapshot, monkeypatch):
    drawn = []
    monkeypatch.setattr(picture, "save_png", lambda figure, path: drawn.append(figure))
    title = "A tissue (with " + ", ".join(f"tissue.some_key_{number} = {number}" for number in range(20)) + ")"
    draw_tissue(make_snapshot(1), tmp_path / "tissue.png", title=title, certified=True)
    (figure,) = drawn
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    (heading,) = (text for text in figure.axes[0].texts if text.get_text().startswith("A tissue"))
    box = heading.get_window_extent(canvas.get_renderer())
    assert box.x1 < figure.bbox.x1 and box.y1 < figure.bbox.y1 and heading.get_text().endswith("…")


def test_tied_cells_that_share_points_are_outlined_apart():
    points = np.array([[x, y, 0.0] for y in (0, 1) for x in (0, 1, 2)])
    tied = Grid(points, np.array([[0, 1, 4, 3], [1, 2, 5, 4]]), 9, cell_data={"cell_id": np.array([7, 8])})
    assert {loop.cell_id: sorted(loop.points) for loop in cell_loops(tied)} == {
        7: [0, 1, 3, 4],
        8: [1, 2, 4, 5],
    }


def test_outlines_do_not_depend_on_shared_points(make_snapshot):
    bulk = make_snapshot(1).bulk
    apart = Grid(
        bulk.points[bulk.cells].reshape(-1, 3),
        np.arange(bulk.cells.size).reshape(-1, 4)[:, ::-1],
        9,
        cell_data=bulk.cell_data,
    )
    for grid in (bulk, apart):
        loops = cell_loops(grid)
        assert sorted((loop.cell_id, loop.outer) for loop in loops) == [
            (0, False), (0, True), (1, False), (1, True),
        ]  # fmt: skip
        assert {len(loop.points) for loop in loops} == {4}


def test_cells_that_are_not_planar_are_refused(tmp_path):
    points = np.vstack([np.zeros(3), np.eye(3)])
    data = {"displacement": np.zeros((4, 3))}
    solid = Grid(points, np.array([[0, 1, 2, 3]]), 10, data, {"cell_id": np.zeros(1, dtype=int)})
    with pytest.raises(OutputError, match="cannot draw cells of VTK type 10"):
        draw_tissue(Snapshot(0, 0.0, 0.0, solid, solid), tmp_path / "a.png", title="", certified=True)


@pytest.fixture
def result(tmp_path, make_snapshot, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    series = SnapshotSeries(tmp_path)
    series.append(make_snapshot(1), certified=True)
    return tmp_path


def test_without_a_display_show_writes_into_the_folder(result):
    assert show(result) == result / "tissue.png"
    assert (result / "tissue.png").exists()


def test_show_writes_where_it_is_told_and_labels_a_refused_run(result):
    good = show(result, screenshot=result / "good.png")
    write_summary(result, {"certified": False})
    bad = show(result, screenshot=result / "bad.png")
    assert red_share(bad) > red_share(good) + 0.01


def test_a_picture_that_cannot_be_written_is_named(result):
    with pytest.raises(OutputError, match="cannot write .*: Not a directory"):
        show(result, screenshot=result / "tissue.pvd" / "a.png")


def test_importing_the_room_loads_no_graphics():
    program = (
        "import sys, ngcell.export; print([m for m in ('pyvista', 'vtkmodules', 'matplotlib') if m in sys.modules])"
    )
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_the_plan_of_onsets_follows_the_data(tmp_path, make_snapshot, make_record):
    history = [make_record(step, 0.01 * step, components=step) for step in range(1, 5)]
    cells = make_snapshot(1).bulk

    def draw(name, onset, certified=True):
        return imread(draw_debonding(history, [(0, 1, onset)], cells, tmp_path / name, certified=certified))

    grey, coloured, _ = draw("a.png", np.nan), draw("b.png", 0.2), draw("c.png", np.nan, False)
    assert grey[..., :3].std() > 0.05
    assert np.mean(np.abs(grey - coloured).max(2) > 0.1) > 1e-3
    assert red_share(tmp_path / "c.png") > red_share(tmp_path / "a.png") + 0.01


def test_the_plan_of_onsets_knows_no_unit_of_length(tmp_path, make_snapshot, make_record):
    history = [make_record(step, 0.01 * step, components=step) for step in range(1, 5)]
    cells, drawn = make_snapshot(1).bulk, []
    for unit in (1.0, 1e-6):
        small = replace(cells, points=unit * cells.points)
        file = draw_debonding(history, [(0, 1, 0.2)], small, tmp_path / "a.png", certified=True)
        drawn.append(imread(file))
    plan = slice(60, None), slice(690, None)  # below the title, whose place depends on the last digits
    assert np.mean(np.abs(drawn[0] - drawn[1])[plan].max(2) > 0.1) < 1e-3
    assert drawn[1][plan][..., :3].std() > 0.05


def test_prisms_are_seen_from_above():
    """Of two hexahedra on top of each other the upper end of the upper one is left, with its data."""
    nodes = pattern_of(ngsolve.ET.HEX, 2).points
    points = np.concatenate([nodes, nodes + [0, 0, 1]])
    cells, cell_id = np.arange(54).reshape(2, 27), {"cell_id": np.array([3, 4])}
    seen = planar_view(Grid(points, cells, 29, {"displacement": 0 * points}, cell_id))
    assert seen.cell_type == 28
    assert seen.cell_data["cell_id"].tolist() == [4]
    assert (seen.points[seen.cells, 2] == 2).all()
    (loop,) = cell_loops(seen)
    assert loop.outer
    np.testing.assert_allclose(seen.points[loop.points[0], :2], [0, 0])


def test_bodies_are_cut_at_a_share_of_their_height_at_rest():
    """Of two hexahedra on top of each other, moved up by half of their height, the lower half of the lower is left."""
    nodes = pattern_of(ngsolve.ET.HEX, 2).points
    points = np.concatenate([nodes, nodes + [0, 0, 1]])
    grid = Grid(points, np.arange(54).reshape(2, 27), 29, {"displacement": 0 * points + [0, 0, 1]}, {})
    snapshot = Snapshot(step=0, load_factor=1.0, plate_displacement=0.0, bulk=grid, walls=grid)
    low, high = _below(_moved(grid), snapshot, grid, 0.25).bounds[4:]
    assert (low, high) == pytest.approx((1.0, 1.5))
    assert _below(_moved(grid), snapshot, grid, None).bounds[5] == 3
