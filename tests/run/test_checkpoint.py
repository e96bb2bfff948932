"""What a step on another mesh takes from the one before."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.build.checkpoint import Checkpoint
from ngcell.results.measure import WorkPoint


@pytest.mark.parametrize(("displacement", "is_kept"), [([0.0, 0.0], True), ([0.0, 0.1], False)])
def test_energies_on_another_mesh_count_only_where_nothing_has_moved(displacement, is_kept):
    """After unloading the load is zero as well, and bodies may be bent."""
    first = Checkpoint(work={"tied": WorkPoint(), "released": WorkPoint()})
    assert set(first.on_level("released", 2).work) == {"tied", "released"}
    point = WorkPoint(load_factor=0.0, energy=0.1)
    after = first.on_level("released", 2).after("released", np.array(displacement), point)
    assert after.on_level("released", 2).work["released"] == point
    assert ("released" in after.on_level("released", 3).work) == is_kept
