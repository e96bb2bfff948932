"""Fluids in lumens: areas, an energy with its derivatives, and pressures that are found."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.mechanics.fluid import LumenFluids
from tests.tissues import NOTHING, SmallTissue, small_tissue

STEPS = np.array([4e-3, 2e-3, 1e-3])


def fluids(tissue: SmallTissue, **options: float) -> LumenFluids:
    found = LumenFluids(tissue.space, "lumen", **({"modulus": 0.7} | options))
    found.apply(1.0)
    return found


def inner_area(wall: float) -> float:
    return 1.5 * np.sqrt(3) * (1 - wall / (np.sqrt(3) / 2)) ** 2


def dense(tissue: SmallTissue, found: LumenFluids, displacement: np.ndarray) -> np.ndarray:
    rows, columns = found.pattern
    assert (rows >= columns).all() and len(set(zip(rows, columns, strict=True))) == len(rows)
    matrix = np.zeros((len(displacement),) * 2)
    matrix[rows, columns] = found.tangent(tissue.space.configuration(displacement))
    return matrix + np.tril(matrix, -1).T


@pytest.mark.parametrize("order", [1, 2, 3])
def test_areas_follow_an_affine_map_exactly(order):
    tissue = small_tissue(1, 3, order=order, wall=0.2)
    found = fluids(tissue)
    assert found.body.tolist() == [0, 1, 2]
    np.testing.assert_allclose(found.area, inner_area(0.2), rtol=1e-12)
    gradient = np.array([[0.2, 0.3], [-0.1, 0.4]])
    moved = tissue.space.affine(gradient, np.array([0.3, -5.0])).ravel()
    np.testing.assert_allclose(found.areas(moved), np.linalg.det(np.eye(2) + gradient) * found.area, rtol=1e-12)
    np.testing.assert_allclose(found.areas(tissue.rigid_motion(1.1, (2.0, 3.0))), found.area, rtol=1e-12)


def test_curved_edges_count():
    """The map x + 0.3 (y + 1)^2, y + 0.1 x has the determinant 1 - 0.06 (y + 1), whose mean over the lumen is 0.94."""
    tissue = small_tissue(1, 1, order=2, wall=0.2)
    found = fluids(tissue)
    field = ngsolve.GridFunction(tissue.space.vector)
    field.Set(ngsolve.CF((0.3 * (ngsolve.y + 1) ** 2, 0.1 * ngsolve.x)))
    assert found.areas(np.array(field.vec.FV().NumPy())) == pytest.approx(0.94 * found.area, rel=1e-10)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_taylor_remainders_of_energy_and_forces_vanish_at_their_rates(order):
    tissue = small_tissue(1, 2, order=order, edges=1)
    found = fluids(tissue, fill=1.1)
    found.pressure = np.array([0.3, -0.2])
    at, way = tissue.smooth(0.3, 1), tissue.smooth(1.0, 2)
    here, bent = tissue.space.configuration(at), dense(tissue, found, at) @ way
    ahead = [tissue.space.configuration(at + h * way) for h in STEPS]
    slope, rise = found.gradient(here), np.array([found.value(there) for there in ahead]) - found.value(here)
    first = np.abs(rise - STEPS * (slope @ way))
    second = np.abs(rise - STEPS * (slope @ way) - STEPS**2 / 2 * (way @ bent))
    forces = [np.linalg.norm(found.gradient(there) - slope - h * bent) for h, there in zip(STEPS, ahead, strict=True)]
    for remainders, rate in ((first, 2), (second, 3), (forces, 2)):
        np.testing.assert_allclose(np.log2(np.array(remainders[:-1]) / remainders[1:]), rate, atol=0.15)


def test_what_is_updated_is_the_pressure_that_the_liquid_answers_with():
    tissue = small_tissue(1, 1)
    found = fluids(tissue, modulus=2.0)
    squeezed = tissue.space.affine(np.diag([-0.01, 0.0]), np.zeros(2)).ravel()
    assert found.missed(squeezed) == pytest.approx(0.01, rel=1e-9)
    assert found.pressures(squeezed) == pytest.approx([0.02], rel=1e-9)
    at = tissue.space.configuration(squeezed)
    forces = found.gradient(at)
    off, energy = found.update_multipliers(at, NOTHING)
    assert off == pytest.approx(0.01 * np.sqrt(found.area[0]), rel=1e-9)
    assert energy == pytest.approx(2.0 * 0.01**2 / 2 * found.area[0], rel=1e-9)
    assert found.pressure == pytest.approx([0.02], rel=1e-9)
    assert found.pressures(squeezed) == pytest.approx([0.04], rel=1e-9)
    found.increase_penalty()
    assert found.pressures(squeezed) == pytest.approx([0.22], rel=1e-9)
    found.apply(1.0)
    np.testing.assert_allclose(found.gradient(at), forces, atol=1e-15)


def test_filling_grows_with_the_load_or_comes_first():
    tissue = small_tissue(1, 1)
    grown, first = fluids(tissue, fill=1.2), fluids(tissue, fill=1.2, in_full=True)
    for load, share in ((0.0, 0.0), (0.25, 0.25), (1.0, 1.0)):
        grown.apply(load)
        first.apply(load)
        assert grown.needed == pytest.approx((1 + 0.2 * share) * grown.area, rel=1e-12)
        assert first.needed == pytest.approx(1.2 * first.area, rel=1e-12)


def test_forces_of_a_fluid_balance_and_are_those_of_its_pressure():
    tissue = small_tissue(1, 1, order=3)
    found = fluids(tissue)
    state = tissue.smooth(0.2, 4)
    force = found.gradient(tissue.space.configuration(state)).reshape(2, -1)
    np.testing.assert_allclose(force @ tissue.space.one, 0, atol=1e-13 * np.abs(force).max())
    # The virtual work on a field that blows the lumen up is minus the pressure times the rise of its area.
    grow = tissue.positions(state)
    assert (force * grow).sum() == pytest.approx(-2 * found.pressures(state)[0] * found.areas(state)[0], rel=1e-10)
