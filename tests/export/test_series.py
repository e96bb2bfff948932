import errno
import os

import numpy as np
import pytest
import pyvista

from ngcell.errors import OutputError
from ngcell.export import SnapshotSeries, read_last_snapshot
from ngcell.results.snapshot import Grid, Snapshot


def opened(folder, time):
    reader = pyvista.get_reader(folder / "tissue.pvd")
    reader.set_active_time_value(time)
    return reader.read()


@pytest.fixture
def series(tmp_path, make_snapshot):
    series = SnapshotSeries(tmp_path)
    series.append(make_snapshot(1, 0.1), certified=True)
    series.append(make_snapshot(3, 0.3), certified=False)
    return series


def test_time_is_the_plate_displacement(series):
    assert pyvista.get_reader(series.folder / "tissue.pvd").time_values == [0.1, 0.3]


def test_time_is_the_load_factor_where_plate_displacements_repeat(tmp_path, make_snapshot):
    series = SnapshotSeries(tmp_path)
    for step in (1, 2, 3):
        series.append(make_snapshot(step, plate_displacement=0.0), certified=True)
    assert pyvista.get_reader(tmp_path / "tissue.pvd").time_values == [0.05, 0.1, 0.15]


def test_every_value_comes_back_exactly(series, make_snapshot):
    written = make_snapshot(3, 0.3)
    for grid, mesh in zip((written.bulk, written.walls), opened(series.folder, 0.3), strict=True):
        assert mesh.points.dtype == np.float64
        assert np.array_equal(mesh.points, grid.points)
        assert np.array_equal(mesh.cells_dict[grid.cell_type], grid.cells)
        for kept, given in ((mesh.point_data, grid.point_data), (mesh.cell_data, grid.cell_data)):
            assert set(kept.keys()) == set(given)
            for name in given:
                assert np.array_equal(kept[name], given[name]), name


def test_pyvista_warps_it(series):
    tissue, walls = opened(series.folder, 0.3)
    assert tissue.warp_by_vector("displacement").bounds.x_max == pytest.approx(2.3)
    assert walls.warp_by_vector("displacement").bounds.x_max == pytest.approx(1.3)


def test_each_file_carries_its_verdict(series):
    for time, verdict in ((0.1, "certified"), (0.3, "NOT CERTIFIED")):
        for mesh in opened(series.folder, time):
            assert list(mesh.field_data["ngcell_verdict"]) == [verdict]


def test_biquadratic_elements_and_no_walls_are_kept(tmp_path):
    axis = np.array([0.0, 0.5, 1.0])
    points = np.array([[x, y, 0.0] for y in axis for x in axis])
    data = {"displacement": np.zeros((9, 3))}
    bulk = Grid(points, np.array([[0, 2, 8, 6, 1, 5, 7, 3, 4]]), 28, data, {"cell_id": np.array([4])})
    walls = Grid(np.empty((0, 3)), np.empty((0, 2), dtype=int), 3)
    SnapshotSeries(tmp_path).append(Snapshot(0, 0.0, 0.0, bulk, walls), certified=True)
    snapshot, certified = read_last_snapshot(tmp_path)
    assert certified
    assert snapshot.bulk.cell_type == 28
    assert np.array_equal(snapshot.bulk.cells, bulk.cells)
    assert len(snapshot.walls.cells) == 0


def test_the_last_snapshot_is_read_back(series):
    snapshot, certified = read_last_snapshot(series.folder)
    assert (snapshot.step, snapshot.load_factor, snapshot.plate_displacement) == (3, 0.15, 0.3)
    assert not certified


def test_a_folder_without_a_series_is_named(tmp_path):
    with pytest.raises(OutputError, match="holds no tissue.pvd"):
        read_last_snapshot(tmp_path)


def test_a_snapshot_that_the_disk_refuses_leaves_the_series_as_it_was(series, make_snapshot, monkeypatch):
    before = {path.name: path.read_bytes() for path in series.folder.iterdir()}
    replace = os.replace

    def refuse_the_list(source, target):
        if target.suffix == ".pvd":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(source, target)

    monkeypatch.setattr(os, "replace", refuse_the_list)
    with pytest.raises(OutputError, match=r"tissue\.pvd: No space left on device"):
        series.append(make_snapshot(4), certified=True)
    assert {path.name: path.read_bytes() for path in series.folder.iterdir()} == before
    monkeypatch.undo()
    series.append(make_snapshot(5), certified=True)
    assert pyvista.get_reader(series.folder / "tissue.pvd").time_values == [0.1, 0.3, 0.5]


def test_a_grid_whose_values_do_not_fit_is_refused():
    with pytest.raises(ValueError, match="'J' has 2 values on 3 points"):
        Grid(np.zeros((3, 3)), np.array([[0, 1, 2]]), 5, {"J": np.ones(2)})
