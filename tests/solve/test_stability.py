"""The lowest curvature of a minimum, against all eigenvalues of the tangent, and saddles that are left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from netgen import occ
from scipy.linalg import eigh

from ngcell.build.simulation import Simulation
from ngcell.results.certificate import LIMITS, common_check
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import StabilityOptions
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.stability import Mode, lowest_mode, modes_as_low, stable_minimum

USUAL = StabilityOptions()


def simulation(down: float, *widths: float) -> Simulation:
    """Slender blocks, compressed along their axes, far from each other."""
    supports = (BodySupport("low"), BodySupport("high", translation=(0.0, -down)))
    blocks = tuple(block(number, width) for number, width in enumerate(widths or (0.1,)))
    return Simulation(BodyScene(blocks, supports, size=0.1, order=2, levels=1))


def block(number: int, width: float) -> Body:
    face = occ.MoveTo(10.0 * number, 0.0).Rectangle(width, 2.0).Face()
    face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = "low", "high"
    return Body(face, MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=10.0), f"block-{number}")


def straight(built: Simulation):
    """Return a minimiser and where Newton's method ends from the straight block."""
    minimiser = built.released.minimisers[-1]
    minimiser.problem.apply(1.0)
    rest = np.zeros(built.space.unknowns)
    start = minimiser.predict(rest, built.motion.imposed(rest, 1.0), built.continuation.scale)
    return minimiser, minimiser.minimise(start, ProximalTerm(0.0, start))


def eigenvalues(minimiser, minimum):
    """Return all eigenvalues of the tangent in the metric of the mass, in ascending order."""
    line, problem = minimiser.problem.linearise(minimum.state), minimiser.problem
    row, column = problem.pattern
    tangent = np.zeros((len(problem.free),) * 2)
    np.add.at(tangent, (row, column), line.stiffness)
    tangent = tangent + np.tril(tangent, -1).T
    of_free = np.ix_(problem.free, problem.free)
    return eigh(tangent[of_free], problem.mass.tocsr().toarray()[of_free], eigvals_only=True)


@pytest.mark.parametrize(("down", "width"), [(0.0005, 0.1), (0.1, 0.1), (0.003, 0.03)])
def test_the_lowest_curvature_is_the_lowest_eigenvalue(down, width):
    """The most slender block has eigenvalues of both signs close to zero, and has just buckled."""
    built = simulation(down, width)
    minimiser, minimum = straight(built)
    assert minimum.is_found
    scale = built.continuation.scale
    mode = lowest_mode(minimiser, minimum, USUAL, scale=scale)
    exact = eigenvalues(minimiser, minimum)[0]
    assert mode.curvature == pytest.approx(exact, abs=0.1 * USUAL.negative * scale, rel=1e-3)
    assert mode.rounds < USUAL.rounds / 2
    assert (mode.curvature < 0) == (down > 0.001)


@pytest.mark.parametrize("widths", [(0.1, 0.1), (0.1, 0.101), (0.1, 0.2)])
def test_a_saddle_is_left_along_all_modes_that_are_as_low(widths):
    """Each block has modes of its own; of two that are equal any mixture would do, and each is found."""
    built = simulation(0.03, *widths)
    minimiser, minimum = straight(built)
    scale, mass = built.continuation.scale, minimiser.problem.mass
    lowest = lowest_mode(minimiser, minimum, USUAL, scale=scale)
    modes = modes_as_low(minimiser, minimum, lowest, USUAL)
    exact = eigenvalues(minimiser, minimum)
    expected = [value for value in exact if value <= USUAL.as_low * exact[0]]
    assert len(expected) == (2 if widths[1] < 0.15 else 1)
    assert [mode.curvature for mode in modes] == pytest.approx(expected, rel=1e-3)
    across = np.array([[one.direction @ (mass @ other.direction) for one in modes] for other in modes])
    assert across == pytest.approx(np.diag(np.diag(across)), abs=1e-3 * across.max())
    stable = stable_minimum(minimiser, minimum, lambda below: below, USUAL, scale=scale, length=built.longest_step)
    assert stable.is_found and stable.lowest_curvature > 0


def test_a_saddle_is_left_and_the_minimum_has_no_negative_curvature():
    built = simulation(0.1)
    minimiser, minimum = straight(built)
    lengths = {"scale": built.continuation.scale, "length": built.longest_step}
    stable = stable_minimum(minimiser, minimum, lambda below: below, USUAL, **lengths)
    assert stable.state.energy < 0.4 * minimum.state.energy
    assert stable.lowest_curvature > 0
    stuck = StabilityOptions(most_saddles=1)
    assert stable_minimum(minimiser, minimum, lambda below: below, stuck, **lengths).ending is Ending.SADDLE


def test_a_block_that_has_just_buckled_is_on_a_saddle_however_low_its_curvature_and_leaves_it():
    built = simulation(0.0173409)
    minimiser, minimum = straight(built)
    lengths = {"scale": built.continuation.scale, "length": built.longest_step}
    curvature = lowest_mode(minimiser, minimum, USUAL, scale=lengths["scale"]).curvature / lengths["scale"]
    assert -2e-4 < curvature < -5e-5
    stable = stable_minimum(minimiser, minimum, lambda below: below, USUAL, **lengths)
    assert stable.is_found and stable.lowest_curvature > 0
    assert stable.state.energy < minimum.state.energy * (1 - 5e-7)


def test_what_lies_below_a_saddle_is_looked_for_again_where_it_was_folded_between_the_points_of_a_rule():
    built = simulation(0.1)
    minimiser, minimum = straight(built)
    energies: list[float] = []

    def met(below: Minimum) -> Minimum:
        energies.append(below.state.energy)
        return replace(below, ending=Ending.NO_ENERGY) if len(energies) == 1 else below

    lengths = {"scale": built.continuation.scale, "length": built.longest_step}
    stable = stable_minimum(minimiser, minimum, met, USUAL, **lengths)
    assert stable.is_found and stable.state.energy < 0.4 * minimum.state.energy
    assert energies[1] == pytest.approx(minimum.state.energy)  # by the finer rule it is sought from the saddle


def test_the_certificate_tells_a_saddle_from_a_minimum():
    built = simulation(0.1)
    (step,) = built.accepted_steps()
    (check,) = (check for check in step.measurement.certificate.checks if check.name == "lowest_curvature")
    assert check.passed and check.value > 0
    assert not common_check("lowest_curvature", -0.01).passed
    assert LIMITS["lowest_curvature"] == -USUAL.negative


def test_a_slender_solid_buckles_as_well():
    """A square column between plates, at nearly twice the strain of (pi w / L)^2 / 3 at which it buckles."""
    solid = occ.Box((0, 0, 0), (0.1, 0.1, 1.0))
    solid.faces.Min(occ.Z).name, solid.faces.Max(occ.Z).name = "low", "high"
    supports = (BodySupport("low"), BodySupport("high", translation=(0.0, 0.0, -0.06)))
    body = Body(solid, MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=10.0), "column")
    (step,) = Simulation(BodyScene((body,), supports, size=0.1, order=2, levels=1, accuracy=np.inf)).accepted_steps()
    compressed = 0.5 * 5.6 * 0.01 * 0.06**2  # Young's modulus is 9 K G / (3 K + G), G = 2 (c1 + c2)
    (check,) = (check for check in step.measurement.certificate.checks if check.name == "lowest_curvature")
    assert step.record.certified and check.value > 0
    assert step.record.energy < 0.8 * compressed


def test_a_matrix_without_an_inverse_is_tried_with_another_weight_and_told_where_none_has_one():
    built = simulation(0.1)
    minimiser, minimum = straight(built)
    scale, stiffened = built.continuation.scale, minimiser.stiffened
    expected = lowest_mode(minimiser, minimum, USUAL, scale=scale).curvature
    weights = []

    def without(fewest: int):
        def found(minimum, weight):
            weights.append(weight)
            return stiffened(minimum, weight) if len(weights) > fewest else lambda force: np.full_like(force, np.nan)

        return found

    minimiser.stiffened = without(1)
    assert lowest_mode(minimiser, minimum, USUAL, scale=scale).curvature == pytest.approx(expected, rel=1e-3)
    assert weights[1] > weights[0]
    minimiser.stiffened = without(10**6)
    assert modes_as_low(minimiser, minimum, Mode(-expected, np.zeros(0), 1), USUAL)[0].curvature == -expected
    assert np.isnan(lowest_mode(minimiser, minimum, USUAL, scale=scale).curvature)
    judged = stable_minimum(minimiser, minimum, lambda below: below, USUAL, scale=scale, length=0.1)
    assert not common_check("lowest_curvature", judged.lowest_curvature).passed
