"""Contact by NGSolve's boundary: one energy with its forces and tangent, and the same one as of the package's pairs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from ngcell.contact.methods.by_ngsolve import NgsolveContact, NgsolveTerm
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.methods.wall_strip import WallStrip, coloured
from ngcell.contact.pairing.near import near_facets
from ngcell.errors import CaseError
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from tests.contact.derivatives import step_between_kinks
from tests.contact.solids import blocks
from tests.tissues import LAW, LONGEST_STEP, SmallTissue, small_tissue

ORDERS = [1, 2, 3]


def term_of(tissue: SmallTissue) -> NgsolveTerm:
    modulus = np.full(tissue.bodies.body_count, LAW.plane_strain_modulus)
    return NgsolveTerm(tissue.walls, penalty_stiffness(tissue.walls, modulus, 1.0), 2 * LONGEST_STEP)


def whole(term: NgsolveTerm, at: Configuration) -> tuple[np.ndarray, sparse.csr_array]:
    """Gradient and tangent of the energy, one-sided terms included."""
    split = term.constraints(at)
    closed = split.jacobian[np.flatnonzero(split.gap < 0)]
    along = closed.T @ closed.multiply(split.penalty[split.gap < 0][:, None])
    return term.gradient(at) + split.gradient, (term.curvature(at) + along).tocsr()


def pressed(tissue: SmallTissue, depth: float) -> np.ndarray:
    """Bent walls, the right cell pressed in by `depth` and along by 0.2."""
    return tissue.smooth(0.02, 3) + tissue.body_translation(1, np.array([-depth, 0.2]))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("depth", [-0.08, 0.01, 0.06])
def test_forces_and_tangent_are_derivatives_of_the_energy_whose_pairs_are_found_anew(order, depth):
    tissue = small_tissue(1, 2, order=order)
    term, at, way = term_of(tissue), pressed(tissue, depth), tissue.smooth(1.0, 8)
    here = tissue.space.configuration(at)
    gap = term.constraints(here).gap
    assert len(gap) and (gap > 0).all() == (depth < 0)
    step = step_between_kinks(gap, term.constraints(here).jacobian @ way)
    after, before = (tissue.space.configuration(at + sign * step * way) for sign in (1, -1))
    force, tangent = whole(term, here)
    assert (term.value(after) - term.value(before)) / (2 * step) == pytest.approx(force @ way, rel=1e-7)
    change = (whole(term, after)[0] - whole(term, before)[0]) / (2 * step)
    np.testing.assert_allclose(change, tangent @ way, atol=1e-6 * np.abs(tangent @ way).max())


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("seed", [3, 4])
def test_energy_forces_and_tangent_are_those_of_the_packages_own_pairs(order, seed):
    """Nine cells that are bent at random press on each other in walls and in corners."""
    tissue = small_tissue(3, 3, order=order)
    term, at = term_of(tissue), tissue.space.configuration(tissue.smooth(0.05, seed))
    own = ContactTerm.constraints(term, at)
    assert (own.gap < 0).sum() > 30
    assert term.value(at) == pytest.approx(ContactTerm.value(term, at), rel=1e-12)
    assert np.abs(term.gradient(at)).max() < 1e-12 * np.abs(own.gradient).max()
    bending = ContactTerm.curvature(term, at)
    assert abs(term.curvature(at) - bending).max() < 1e-8 * abs(whole(term, at)[1]).max()


def test_bodies_that_come_near_each_other_get_different_colours():
    """A cell is moved past its neighbours onto one that it was far from, of its own colour until then."""
    tissue = small_tissue(1, 3)
    term, rest = term_of(tissue), tissue.space.configuration(np.zeros(tissue.space.unknowns))
    assert term.value(rest) < 1e-25
    away = tissue.lattice.centres[2] - tissue.lattice.centres[0]
    onto = tissue.body_translation(0, away * (1 - 1.7 / np.linalg.norm(away)) + np.array([0.0, 1e-3]))
    onto += tissue.body_translation(1, np.array([0.0, 5.0]))
    at = tissue.space.configuration(onto)
    assert term.value(at) > 1e-4
    assert term.value(at) == pytest.approx(ContactTerm.value(term, at), rel=1e-12)


def test_colours_differ_where_they_have_to_and_are_few():
    tissue = small_tissue(4, 5)
    one, two = (tissue.walls.body[facet] for facet in near_facets(tissue.walls, tissue.walls.rest, 0.1))
    colours = coloured(20, one, two)
    assert (colours[one] != colours[two]).all() and colours.max() <= 3
    strip = WallStrip(tissue.walls, colours)
    names = {f"{kind}{colour}" for kind in ("wall", "point") for colour in range(colours.max() + 1)}
    assert set(strip.mesh.GetBoundaries()) == names


def test_contact_goes_on_where_another_stage_ended():
    """The solver hands over from a softer stage; nothing but the energy changes."""
    tissue = small_tissue(1, 2)
    soft, stiff = NgsolveContact().stages(tissue.walls, np.full(2, 3.0), reach=2 * LONGEST_STEP)
    problems = [Problem(tissue.space, [tissue.bulk, term], tissue.motion.fixed) for term in (soft, stiff)]
    at = pressed(tissue, 0.01)
    problems[1].start_from(problems[0], problems[1].at(at))
    ratio = stiff.value(tissue.space.configuration(at)) / soft.value(tissue.space.configuration(at))
    assert ratio == pytest.approx(stiff.stiffness[0] / soft.stiffness[0])
    assert problems[1].update_multipliers(problems[1].at(at)) == (0.0, 0.0)


def test_three_dimensions_are_refused_in_words():
    walls = blocks(1).walls
    with pytest.raises(CaseError, match="'ngsolve' in three dimensions; allowed: contact.kind = 'penalty', 'mortar'"):
        NgsolveContact().stages(walls, np.ones(2), reach=0.1)
