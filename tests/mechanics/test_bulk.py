"""The stored energy of bodies: energy, forces and tangent of one function, material by material."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.symbolic_sum import SymbolicSum
from ngcell.results.jacobian import smallest_jacobian
from tests.mechanics.test_hyperelastic import stored_energy
from tests.tissues import LAW, SmallTissue, small_tissue

STEPS = np.array([4e-3, 2e-3, 1e-3])


def rates(remainders: list[float]) -> np.ndarray:
    return np.log2(np.array(remainders[:-1]) / remainders[1:])


@pytest.mark.parametrize(
    "law", [MooneyRivlin(c1=0.7, c2=0.3, bulk_modulus=20.0), MooneyRivlin(c1=1.0, c2=0.0, bulk_modulus=20.0)]
)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_taylor_remainders_of_energy_and_forces_vanish_at_their_rates(law, order):
    tissue = small_tissue(1, 1, order=order, edges=1)
    bulk = BodyEnergy(tissue.space, [law]).form
    at, way = tissue.smooth(0.3, 1), tissue.smooth(1.0, 2)
    energy, force = bulk.energy(at), bulk.gradient(at)
    tangent = bulk.tangent(at)
    np.testing.assert_allclose(tangent.toarray(), tangent.toarray().T, atol=1e-11)
    bent = tangent @ way
    first = [abs(bulk.energy(at + h * way) - energy - h * force @ way) for h in STEPS]
    second = [abs(bulk.energy(at + h * way) - energy - h * force @ way - h * h / 2 * way @ bent) for h in STEPS]
    forces = [np.linalg.norm(bulk.gradient(at + h * way) - force - h * bent) for h in STEPS]
    np.testing.assert_allclose(rates(first), 2, atol=0.15)
    np.testing.assert_allclose(rates(second), 3, atol=0.15)
    np.testing.assert_allclose(rates(forces), 2, atol=0.15)


def test_each_body_stores_energy_by_its_own_law():
    tissue = small_tissue(1, 3, order=1)
    soft, hard = MooneyRivlin(c1=1.0, c2=0.5, bulk_modulus=10.0), MooneyRivlin(c1=30.0, c2=0.0, bulk_modulus=300.0)
    gradient = np.array([[0.1, 0.2], [-0.05, 0.15]])
    field = tissue.space.affine(gradient, np.zeros(2)).ravel()
    area = tissue.volume / 3
    expected = area * sum(stored_energy(law, np.eye(2) + gradient) for law in (soft, hard, soft))
    bulk = BodyEnergy(tissue.space, [soft, hard, soft]).form
    assert bulk.energy(field) == pytest.approx(expected, rel=1e-12)
    forces = bulk.gradient(field)
    lone = BodyEnergy(tissue.space, [hard] * 3).form.gradient(field)
    member = np.tile(tissue.space.body_of_unknown == 1, 2)
    np.testing.assert_allclose(forces[member], lone[member], atol=1e-12)


def test_a_law_for_every_body_is_demanded():
    with pytest.raises(ValueError):
        _ = BodyEnergy(small_tissue(1, 2).space, [LAW]).form


@pytest.mark.parametrize("order", [1, 2, 4])
def test_forces_balance_in_any_state(order):
    tissue = small_tissue(1, 1, order=order)
    displacement = tissue.smooth(0.3, 5)
    force = tissue.bulk.form.gradient(displacement).reshape(2, -1)
    x, y = tissue.positions(displacement)
    largest = np.abs(force).max()
    np.testing.assert_allclose(force @ tissue.space.one, 0, atol=1e-12 * largest)
    assert (x @ force[1] - y @ force[0]) == pytest.approx(0, abs=1e-11 * largest)  # no torque either


def test_an_inverted_element_has_no_energy():
    tissue = small_tissue(1, 1)
    mirrored = tissue.space.affine(np.diag([-2.0, 0.0]), np.zeros(2)).ravel()
    assert np.isnan(tissue.bulk.form.energy(mirrored))


def squeezed(tissue: SmallTissue, by: float, rate: float = 6.0) -> np.ndarray:
    """A displacement that squeezes bands of the walls to `1 - by` of their volume, and stretches those between."""
    x, _ = tissue.space.rest
    moved = np.zeros((2, tissue.space.size))
    moved[0] = by / rate * np.sin(rate * x) * (tissue.space.one > 0)
    return moved.ravel()


def test_squeezed_elements_get_a_rule_that_knows_their_corners_then_one_that_misses_less():
    tissue = small_tissue(1, 1, order=3, edges=2)
    at = tissue.space.configuration(squeezed(tissue, 0.8))
    exact = BodyEnergy(tissue.space, [LAW]).finer(40).value(at)
    bulk = BodyEnergy(tissue.space, [LAW], may_miss=1e-7)
    total, off = SymbolicSum([bulk]), []
    for rank in (1, 2):
        assert bulk.take_finer_rule(at) and bulk.rule == (rank,)
        off.append(abs(total.value(at) - exact))
    assert off[0] > 1e-7 * exact > 10 * off[1]
    assert not bulk.take_finer_rule(at)
    way, step = tissue.smooth(1.0, 2), 1e-6
    ahead, behind = (tissue.space.configuration(at.displacement + h * way) for h in (step, -step))
    assert total.gradient(at) @ way == pytest.approx((total.value(ahead) - total.value(behind)) / (2 * step), rel=1e-6)


def test_a_corner_that_is_inside_out_has_no_energy_by_a_finer_rule():
    tissue = small_tissue(1, 1, order=2, edges=2)
    bulk = BodyEnergy(tissue.space, [LAW], may_miss=1e-2)
    corner = int(np.argmax(tissue.space.rest[1] * (tissue.space.one > 0)))
    moved = np.zeros((2, tissue.space.size))
    while smallest_jacobian(tissue.space, moved.ravel()).value > 0:
        moved[1, corner] -= 1e-3
    at = tissue.space.configuration(moved.ravel())
    assert np.isfinite(bulk.value(at)) and np.isfinite(bulk.finer(8).value(at))
    assert bulk.take_finer_rule(at)
    assert np.isnan(bulk.value(at))


def test_a_rule_stays_where_no_element_is_squeezed_flat():
    """What it misses of volumes that hardly change is locking."""
    tissue = small_tissue(1, 1, order=2, edges=2)
    bulk = BodyEnergy(tissue.space, [LAW], may_miss=1e-7)
    rough = 1e-3 * np.random.default_rng(1).standard_normal(tissue.space.unknowns)
    at = tissue.space.configuration(rough)
    assert abs(bulk.finer(20).value(at) / bulk.value(at) - 1) > 1e-7
    assert not bulk.take_finer_rule(at) and bulk.rule == (0,)


def test_a_finer_rule_is_remembered_and_handed_on():
    tissue = small_tissue(1, 1, order=3, edges=2)
    space, flat = tissue.space, tissue.space.configuration(squeezed(tissue, 0.8))
    bulk, other = (BodyEnergy(space, [LAW], may_miss=1e-7) for _ in range(2))
    assert bulk.memory() == {}
    bulk.take_finer_rule(flat)
    finer = bulk.rule
    assert finer > (0,)
    other.recall(bulk.memory())
    assert other.rule == finer
    other.recall({})
    assert other.rule == (0,)
    other.start_from(bulk, flat)
    assert other.rule == finer
    bulk.refine(BodyEnergy(space, [LAW]), flat)  # a step depends on what the coarser mesh found, and no other
    assert bulk.rule == (0,)
    other.start_from(bulk, flat)
    assert other.rule == finer
