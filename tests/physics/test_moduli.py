"""In-plane moduli of endless tied tissues at rest: those of frames of beams, as walls become thin."""

from __future__ import annotations

import numpy as np
import pytest

from tools.references.moduli import BULK, FRAMES, SHEAR, compared, endless

THIN = 0.01


def over_closed_forms(name: str, ratio: float) -> np.ndarray:
    rows = compared(name, FRAMES[name], ratio)
    assert all(row["mesh_error"] < 1e-3 for row in rows)
    return np.array([row["over_closed_form"] for row in rows])


@pytest.mark.parametrize("name", FRAMES)
def test_thin_walls_are_beams_of_gibson_and_ashby(name):
    """What stiffens the joints is of first order in the thickness over the length: less than 1.1 of it."""
    thin, thick = over_closed_forms(name, THIN), over_closed_forms(name, 2 * THIN)
    assert (thin > 1).all() and (thin < 1 + 1.1 * THIN).all()
    np.testing.assert_allclose(2 * thin - thick, 1, atol=2e-3)


def test_a_regular_honeycomb_is_isotropic():
    along_x, along_y, shear = endless(FRAMES["honeycomb"], 0.1, 3)
    assert along_x == pytest.approx(along_y, rel=1e-9)
    assert along_x / (2 * shear) - 1 == pytest.approx(0.96, abs=0.02), "nearly that of an incompressible sheet"


def test_bricks_are_those_of_stretched_walls_along_their_rows():
    """Rows of a wall of this thickness in each unit of height bear what they bear alone, but for the upright walls."""
    poisson = (3 * BULK - 2 * SHEAR) / (6 * BULK + 2 * SHEAR)
    alone = 0.05 * 2 * SHEAR / (1 - poisson)
    along_x, *_ = endless(FRAMES["brick"], 0.05, 3)
    assert 1 < along_x / alone < 1.01
