"""The rotation of a cell is that of the polar decomposition of its affine map, whatever its shape."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import polar

from ngcell import Brick, MeshChoice
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.observables.rotation import Rotation
from tests.tissues import rotation


@pytest.mark.parametrize("gradient", [np.eye(2), rotation(0.4), [[1.0, 0.2], [0.0, 1.0]], [[1.3, -0.4], [0.1, 0.8]]])
def test_long_cells_turn_as_their_affine_map_says(gradient):
    gradient = np.array(gradient)
    bodies = Brick(rows=1, cols=2, aspect=3.0, wall=0.1).mesh(None, MeshChoice(order=2))
    space = DisplacementSpace(bodies, 2)
    positions = space.rest + space.affine(gradient - np.eye(2), np.array([0.3, -0.1]))
    turn = polar(gradient)[0]
    view = SimpleNamespace(problem=SimpleNamespace(space=space), positions=positions)
    expected = np.degrees(np.arctan2(turn[1, 0], turn[0, 0]))
    np.testing.assert_allclose(Rotation().values(view), np.full(2, expected), rtol=0, atol=1e-10)
