"""Synthetic results: two square rings side by side, moved apart by a known displacement."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.results.record import StepRecord, WallRecord
from ngcell.results.snapshot import Grid, Snapshot

_FRAME = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_INSET = 0.5 + 0.8 * (_FRAME - 0.5)


def ring_bodies(apart: float) -> Grid:
    """Two unit rings of four linear quads each; the right one moved by `apart` in x and held by nothing."""
    ring = np.vstack([_FRAME, _INSET])
    points = np.zeros((16, 3))
    points[:8, :2], points[8:, :2] = ring, ring + [1.0, 0.0]
    quads = np.array([[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)])
    displacement = np.zeros((16, 3))
    displacement[8:, 0] = apart
    data = {
        "displacement": displacement,
        "J": 1.0 + np.arange(16) / 7.0,
        "cauchy_stress": np.arange(144).reshape(16, 9) / 3.0,
        "von_mises": np.arange(16) / 3.0,
    }
    owner = np.repeat([0, 1], 4)
    return Grid(points, np.vstack([quads, quads + 8]), 9, data, {"cell_id": owner, "free": owner})


def facing_walls(apart: float) -> Grid:
    """The two coincident walls between the rings, as lines."""
    points = np.array([[1.0, 0, 0], [1.0, 1, 0], [1.0, 0, 0], [1.0, 1, 0]])
    displacement = np.zeros((4, 3))
    displacement[2:, 0] = apart
    data = {"displacement": displacement, "gap": np.full(4, apart), "contact_pressure": np.zeros(4)}
    return Grid(points, np.array([[0, 1], [2, 3]]), 3, data, {"cell_id": np.array([0, 1])})


@pytest.fixture
def make_snapshot():
    def make(step: int, apart: float = 0.1, *, plate_displacement: float | None = None) -> Snapshot:
        moved = step / 10 if plate_displacement is None else plate_displacement
        return Snapshot(step, step / 20, moved, ring_bodies(apart), facing_walls(apart))

    return make


@pytest.fixture
def make_record():
    def make(step: int, gap: float = 0.1, **changes) -> StepRecord:
        row = dict(
            step=step, phase="released", load_factor=step / 20, plate_displacement=step / 10, largest_gap=gap,
            mean_gap=gap / 3, smallest_gap=-1e-17, parted_pairs=step, opened_share=0.5, components=1,
            largest_component=2,
            plate_force_x=1 / 3, plate_force_y=-2 / 3, contact_force=0.1, energy=1e-300, iterations=7, factorisations=8,
            seconds=0.1, certified=True,
        )  # fmt: skip
        return StepRecord(**(row | changes))

    return make


@pytest.fixture
def wall_records():
    def make(step: int) -> list[WallRecord]:
        return [WallRecord(step, step / 20, 0, 1, 0.1, 0.05, 0.0, 1.0, True, 0, np.nan)]

    return make
