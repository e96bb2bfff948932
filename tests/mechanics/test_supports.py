"""Prescribed motion: exact where it is affine, at every order; resultants are forces."""

from __future__ import annotations

from types import SimpleNamespace

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from tests.tissues import small_tissue

GRADIENT = np.array([[0.1, 0.3], [-0.2, 0.05]])
TRANSLATION = np.array([0.4, -0.1])


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_support_follows_its_affine_map_at_every_point(order):
    tissue = small_tissue(2, 2, order=order)
    motion = PrescribedMotion(tissue.space, [Support("low|high", GRADIENT, TRANSLATION)])
    field = tissue.space.function(motion.imposed(tissue.smooth(0.1, 1), 0.5))
    place = ngsolve.CF((ngsolve.x, ngsolve.y))
    wanted = 0.5 * (ngsolve.CF(tuple(GRADIENT.ravel()), dims=(2, 2)) * place + ngsolve.CF(tuple(TRANSLATION)))
    wrong = field - wanted
    held = tissue.bodies.mesh.Boundaries("low|high")
    assert ngsolve.Integrate(wrong * wrong, held, order=2 * order) < 1e-26
    assert ngsolve.Integrate(wrong * wrong, tissue.bodies.mesh.Boundaries("wall"), order=2 * order) > 1e-6


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_affine_unknowns_are_the_affine_function(order):
    space = small_tissue(1, 2, order=order).space
    field = space.function(space.affine(GRADIENT, TRANSLATION))
    place = ngsolve.CF((ngsolve.x, ngsolve.y))
    wrong = field - ngsolve.CF(tuple(GRADIENT.ravel()), dims=(2, 2)) * place - ngsolve.CF(tuple(TRANSLATION))
    assert ngsolve.Integrate(wrong * wrong, space.mesh, order=2 * order) < 1e-26


def test_only_the_named_components_are_prescribed_and_the_later_support_counts():
    tissue = small_tissue(1, 1)
    still = np.zeros((2, 2))
    low, high = tissue.space.region_unknowns("low"), tissue.space.region_unknowns("high")
    motion = PrescribedMotion(
        tissue.space,
        [
            Support("low", still, TRANSLATION, components=(False, True)),
            Support("low|high", still, 2 * TRANSLATION, components=(True, False)),
            Support("high", still, 3 * TRANSLATION),
        ],
    )
    one = tissue.space.one
    moved = motion.imposed(np.full(tissue.space.unknowns, 7.0), 1.0).reshape(2, -1)
    np.testing.assert_allclose(moved[1, low], TRANSLATION[1] * one[low])
    np.testing.assert_allclose(moved[0, high], 3 * TRANSLATION[0] * one[high])
    assert motion.fixed[:, low].all() and motion.fixed[:, high].all()
    assert (moved[~motion.fixed] == 7).all()


def test_imposing_leaves_its_argument_alone():
    tissue = small_tissue(1, 1, prescribed_displacement=(0.2, 0.0))
    before = tissue.smooth(0.1, 1)
    kept = before.copy()
    tissue.motion.imposed(before, 1.0)
    np.testing.assert_array_equal(before, kept)


def test_the_lifting_meets_the_supports_and_grows_with_the_load():
    tissue = small_tissue(3, 3, prescribed_displacement=(0.3, -0.1))
    full, half = tissue.motion.lifting(1.0), tissue.motion.lifting(0.5)
    np.testing.assert_allclose(half, full / 2, atol=1e-15)
    np.testing.assert_array_equal(full, tissue.motion.imposed(full, 1.0))
    assert np.isfinite(tissue.bulk.form.energy(full))


def test_the_resultant_is_the_energy_per_translation_of_the_region():
    tissue = small_tissue(1, 1, order=3)
    displacement, size = tissue.smooth(0.3, 4), 1e-5
    force = tissue.bulk.form.gradient(displacement)
    member = np.zeros(tissue.space.size)
    member[tissue.space.region_unknowns("high")] = 1
    for axis, direction in enumerate(np.eye(2)):
        way = (direction[:, None] * member * tissue.space.one).ravel()
        rise = tissue.bulk.form.energy(displacement + size * way) - tissue.bulk.form.energy(displacement - size * way)
        assert tissue.motion.resultant(force, "high")[axis] == pytest.approx(rise / (2 * size), rel=1e-6)


@pytest.mark.parametrize(("order", "slope"), [(2, 0.0), (3, 0.0), (3, 1.0), (5, 1.0)])
def test_a_resultant_has_nothing_of_the_forces_on_supports_beside_it(order, slope):
    """A square whose four sides are held, with stresses that are balanced: sigma_xx = 2 + slope y, sigma_yy = 3 + slope
    x, sigma_xy = 5. Sums over unknowns of a side have half an element's worth of what the sides next to it bear."""
    square = occ.Rectangle(1, 1).Face()
    for edge, name in ((occ.Y, "top"), (occ.X, "right")):
        square.edges.Max(edge).name = name
    square.edges.Min(occ.X).name, square.edges.Min(occ.Y).name = "left", "bottom"
    mesh = ngsolve.Mesh(occ.OCCGeometry(square, dim=2).GenerateMesh(maxh=0.4))
    space = DisplacementSpace(SimpleNamespace(mesh=mesh, body_count=1, dimension=2, rounded=None), order)
    stress = ngsolve.CF((2 + slope * ngsolve.y, 5, 5, 3 + slope * ngsolve.x), dims=(2, 2))
    force = np.zeros((2, space.size))
    for axis in range(2):
        form = ngsolve.LinearForm(space.scalar)
        form += stress[axis, :] * ngsolve.grad(space.scalar.TestFunction()) * ngsolve.dx
        form.Assemble()
        force[axis] = form.vec.FV().NumPy()
    motion = PrescribedMotion(space, [Support("top|left|right|bottom", np.zeros((2, 2)), np.zeros(2))])
    wanted = {"top": (5, 3 + slope / 2), "right": (2 + slope / 2, 5), "left": (-2 - slope / 2, -5)}
    for side, tractions in wanted.items():
        np.testing.assert_allclose(motion.resultant(force.ravel(), side), tractions, rtol=1e-10)
    both = motion.resultant(force.ravel(), "top|right")
    np.testing.assert_allclose(both, np.add(wanted["top"], wanted["right"]), rtol=1e-10)
    whole = motion.resultant(force.ravel(), "top|left|right|bottom")
    np.testing.assert_allclose(whole, 0, atol=1e-12)
    mine = space.region_unknowns("top|right")
    summed = (force * space.one)[:, mine].sum(1)
    assert np.abs(summed - np.add(wanted["top"], wanted["right"])).min() > 0.1
