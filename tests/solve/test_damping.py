"""Steps are damped in the bodies where the model of the energy fails, and nowhere else."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy import sparse

from ngcell.solve.damping import Damper
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.proximal import ProximalTerm

BODIES = 20


@dataclass
class Line:
    gradient: np.ndarray
    stiffness: np.ndarray
    curvature: None = None
    gap: np.ndarray = field(default_factory=lambda: np.zeros(0))
    jacobian: sparse.csr_array = field(default_factory=lambda: sparse.csr_array((0, BODIES)))
    penalty: np.ndarray = field(default_factory=lambda: np.zeros(0))
    keys: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


@dataclass
class Place:
    displacement: np.ndarray
    energy: float


class Bowls:
    """Bodies with one unknown each: ``cosh(sharp x)`` over ``sharp**2``, sharp in some and smooth in the others."""

    dimension = 2
    free = np.ones(BODIES, dtype=bool)
    part = solid = np.arange(BODIES)
    mass = metric = sparse.csr_array(np.eye(BODIES))
    pattern = (np.arange(BODIES), np.arange(BODIES))

    def __init__(self, sharp: int) -> None:
        self.sharp = np.where(np.arange(BODIES) < sharp, 30.0, 0.1)

    def at(self, displacement: np.ndarray) -> Place:
        return Place(displacement, float(np.sum((np.cosh(self.sharp * displacement) - 1) / self.sharp**2)))

    def move(self, displacement: np.ndarray, step: np.ndarray) -> np.ndarray:
        return displacement + step

    def gradient(self, state: Place) -> np.ndarray:
        return np.sinh(self.sharp * state.displacement) / self.sharp

    def linearise(self, state: Place) -> Line:
        return Line(self.gradient(state), np.cosh(self.sharp * state.displacement))

    def gaps(self, state: Place) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(0, dtype=np.int64), np.zeros(0)

    def note_kinks(self, state: Place) -> bool:
        return False

    def couplings(self, state: Place, margin: float) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)


def damper(**numbers: float) -> Damper:
    return Damper(sparse.csr_array(np.eye(4)), np.array([0, 0, 1, 2]), MinimiserOptions(**numbers))


def test_only_bodies_that_lack_energy_are_damped_as_far_as_the_slope_makes_it_felt():
    step = np.array([0.1, 0.0, 0.2, 0.3])
    raised = damper(felt=0.1).raised(np.zeros(3), step, -5.0, np.array([3.0, 1.0, -2.0]))
    # The damping times the squared way of both is a tenth of the slope.
    np.testing.assert_allclose(raised, [0.5 / (0.01 + 0.04), 0.5 / (0.01 + 0.04), 0.0])


def test_damping_is_felt_even_where_nothing_is_known_of_the_energy():
    raised = damper().raised(np.zeros(3), np.full(4, 0.1), -1.0, np.zeros(3))
    assert (raised > 0).all()
    again = damper().raised(raised, np.full(4, 0.1), -1.0, np.zeros(3))
    assert (again >= 8 * raised).all()


def test_bodies_that_would_go_too_far_are_damped_to_go_as_far_as_the_cut_step_and_others_are_not():
    step = np.array([0.1, 0.0, 0.001, 0.05])
    damping = damper(short=0.1).shortened(np.array([0.0, 0.5, 0.0]), step, -5.0)
    needed = 5.0 / (0.01 + 0.0025)
    np.testing.assert_allclose(damping, [needed, 0.5, needed])
    assert damper().shortened(damping, step, -5.0)[0] > 2 * damping[0]


def test_damping_makes_a_model_convex_along_a_way_in_the_bodies_that_fall_along_it():
    way, lacking = np.array([0.1, 0.0, 0.2, 0.3]), np.array([-2.0, 5.0, 0.0])
    damping = damper().straightened(np.array([0.0, 1.0, 7.0]), way, lacking)
    np.testing.assert_allclose(damping, [0.0, 5.0 / 0.04, 7.0])
    np.testing.assert_allclose(damper().straightened(damping, way, lacking)[1], 8 * damping[1])


def test_a_fault_is_local_in_less_than_half_of_the_bodies():
    chain = sparse.csr_array(np.array([[1.0, 0, 1, 0], [0, 0, 1, 1]]))
    assert damper().is_local(np.array([-2.0, 5.0, 0.0]), chain)
    assert not damper().is_local(np.array([3.0, 5.0, 0.0]), chain)
    assert not damper().is_local(np.array([-3.0, 0.0, -1.0]), chain)
    assert not damper().is_local(np.full(3, np.nan), chain)


def test_a_body_that_contact_does_not_couple_does_not_count():
    pair = sparse.csr_array(np.array([[1.0, 0, 1, 0]]))
    assert not damper().is_local(np.array([-2.0, 5.0, 0.0]), pair)
    assert not damper().is_local(np.array([0.0, 0.0, 5.0]), pair)


class OneAstray(Bowls):
    """Bowls ``(x - 1)**2 / 2``, of which the model hardly holds one body as long as it is far from there."""

    def __init__(self) -> None:
        super().__init__(0)

    def at(self, displacement: np.ndarray) -> Place:
        return Place(displacement, float(((displacement - 1) ** 2).sum() / 2))

    def gradient(self, state: Place) -> np.ndarray:
        return state.displacement - 1

    def linearise(self, state: Place) -> Line:
        stiffness = np.ones(BODIES)
        stiffness[0] = 1e-4 if abs(state.displacement[0] - 1) > 0.1 else 1.0
        return Line(self.gradient(state), stiffness)


def test_one_body_that_is_hardly_held_does_not_hold_up_the_others():
    """The minimum is at 1, three steps and a bit away; cut as one, steps would be those of the one body alone."""
    minimiser, start = Minimiser(OneAstray(), 0.3, energy_scale=1.0), np.zeros(BODIES)
    on_the_way = minimiser.minimise(start, ProximalTerm(0.0, start), most=4)
    assert (on_the_way.state.displacement > 0.7).all()
    assert minimiser.minimise(start, ProximalTerm(0.0, start)).ending is Ending.CONVERGED


class OneFolds(Bowls):
    """Bowls ``(x - 1)**2 / 2``, but for one body with ``x - 1 - log(x)``, which has no energy where x <= 0."""

    def __init__(self) -> None:
        super().__init__(0)

    def at(self, displacement: np.ndarray) -> Place:
        energies, x = (displacement - 1) ** 2 / 2, displacement[0]
        energies[0] = x - 1 - np.log(x) if x > 0 else np.nan
        return Place(displacement, float(energies.sum()))

    def folded(self, state: Place) -> np.ndarray:
        return np.where(np.arange(BODIES) == 0, state.displacement <= 0, False)

    def gradient(self, state: Place) -> np.ndarray:
        slope = state.displacement - 1
        slope[0] = 1 - 1 / state.displacement[0]
        return slope

    def linearise(self, state: Place) -> Line:
        stiffness = np.ones(BODIES)
        stiffness[0] = state.displacement[0] ** -2
        return Line(self.gradient(state), stiffness)


def test_one_body_that_folds_is_damped_and_the_others_are_not():
    """From 3 the first step of the one body leads to -3, that of the others to their minimum."""
    start = np.full(BODIES, 3.0)
    minimiser = Minimiser(OneFolds(), np.inf, energy_scale=1.0)
    once = minimiser.minimise(start, ProximalTerm(0.0, start), most=1)
    np.testing.assert_allclose(once.state.displacement[1:], 1.0)
    assert 0 < once.state.displacement[0] < 3
    found = minimiser.minimise(start, ProximalTerm(0.0, start))
    assert found.ending is Ending.CONVERGED
    np.testing.assert_allclose(found.state.displacement, 1.0, rtol=1e-6)


def test_damping_ends_at_exactly_nothing():
    damping = np.array([1.0, 0.0, 1e-3])
    for _ in range(20):
        damping = damper().relaxed(damping, np.full(4, 0.1), -1.0, np.zeros(3), 1.0)
    np.testing.assert_array_equal(damping, 0.0)


@pytest.mark.parametrize("start", [0.03, 0.3])
def test_one_sharp_body_does_not_hold_up_the_others(start):
    def iterations(sharp: int, weight: float) -> int:
        minimiser = Minimiser(Bowls(sharp), np.inf, energy_scale=1.0)
        held = ProximalTerm(weight, np.zeros(BODIES))
        assert minimiser.minimise(np.full(BODIES, start), held).ending is Ending.CONVERGED
        return minimiser.effort.iterations

    assert iterations(1, 0.0) <= iterations(BODIES, 0.0) + 1
