"""How cells end: marks in the picture, and what is read back from the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.image import imread

from ngcell.export import draw_debonding
from ngcell.export.debonding import read_last_ends
from ngcell.export.tables import RecordTable
from ngcell.results.record import CellRecord


def test_each_cell_is_marked_by_how_it_ended(tmp_path, make_snapshot, make_record):
    history, cells = [make_record(step, 0.01 * step) for step in range(1, 5)], make_snapshot(1).bulk
    pairs, path, drawn = [(0, 1, np.nan)], tmp_path / "ends.png", []
    for ends in ((), ("whole", "burst"), ("separated", "burst")):
        drawn.append(imread(draw_debonding(history, pairs, cells, path, certified=True, ends=ends)))
    plain, whole, separated = drawn
    for one, two in ((plain, whole), (whole, separated)):
        assert np.mean(np.abs(one - two).max(2) > 0.1) > 1e-4


def test_ends_are_read_from_the_last_level(tmp_path: Path):
    def cell(step: int, number: int, burst_at: float, separated_at: float) -> CellRecord:
        more = {"utilisation": 0.5, "burst_at": burst_at, "separated_at": separated_at, "burst_energy": 0.0}
        return CellRecord(step, step / 2, 0.1, number, 0.0, 0, 2, True, more)

    nan, path = float("nan"), tmp_path / "cells.csv"
    table = RecordTable(path, CellRecord)
    table.append(cell(1, 0, nan, nan), cell(1, 1, nan, nan))
    table.append(cell(2, 0, 0.6, 0.7), cell(2, 1, nan, 0.9))
    table.close()
    assert read_last_ends(path) == ["burst", "separated"]
    plain = RecordTable(tmp_path / "plain.csv", CellRecord)
    plain.append(CellRecord(1, 0.5, 0.1, 0, 0.0, 0, 1, True))
    plain.close()
    assert read_last_ends(tmp_path / "plain.csv") == []
