"""Pairs, forces and tangent against NGSolve's own contact boundary with the secondary side's deformed normal.

Both are given the same points: a Gauss rule on the two walls between two cells, each of them primary in turn
with half of the stiffness.
"""

from __future__ import annotations

from dataclasses import replace

import ngsolve
import numpy as np
import pytest

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.space import csr_matrix
from tests.tissues import SmallTissue, small_tissue

STIFFNESS = 40.0
REACH = 0.15


def facing_cells(order: int) -> SmallTissue:
    """Two cells whose walls between them are regions of their own, ``left`` and ``right``."""
    normals = small_tissue(1, 2).lattice.normals
    right = int(np.argmax(normals[:, 0]))
    members = {name: np.zeros((2, 6), dtype=bool) for name in ("left", "right")}
    members["left"][0, right] = members["right"][1, (right + 3) % 6] = True
    return small_tissue(1, 2, order=order, edges=3, supports=members)


def with_gauss_points(walls: Surface, count: int) -> Surface:
    points, weights = np.polynomial.legendre.leggauss(count)
    length = np.linalg.norm(walls.rest[:, -1] - walls.rest[:, 0], axis=1)
    return replace(walls, quadrature_points=(points + 1) / 2, weights=length[:, None] * weights / 2)


def displaced(tissue: SmallTissue, right: ngsolve.CF) -> ngsolve.GridFunction:
    """The left cell sheared a little, the right one moved as told; smooth walls, without kinks."""
    x, y = ngsolve.x - np.sqrt(3) / 2, ngsolve.y
    left = ngsolve.CF((0.02 * y, 0.01 * x))
    field = ngsolve.GridFunction(tissue.space.vector)
    field.Set(tissue.bodies.mesh.MaterialCF({"cell0": left, "cell1": right}))
    return field


def bent_out(closest: float) -> ngsolve.CF:
    """A displacement that bends the right cell's wall: nearest in its middle, 0.04 further at its ends."""
    x, y = ngsolve.x - np.sqrt(3) / 2, ngsolve.y
    return ngsolve.CF((closest + 0.16 * y * y + 0.02 * x * y, 0.02 - 0.05 * y))


def shortened(closest: float) -> ngsolve.CF:
    """A displacement that leaves the wall straight, but slightly inclined and shorter than its neighbour."""
    x, y = ngsolve.x - np.sqrt(3) / 2, ngsolve.y
    return ngsolve.CF((closest + 0.025 * y, 0.02 * x - 0.02 * y))


def symbolic_contact(
    tissue: SmallTissue, field: ngsolve.GridFunction, points: int
) -> tuple[ngsolve.BilinearForm, list[ngsolve.ContactBoundary]]:
    """The penalty energy of both passes in NGSolve, and its contact boundaries, which must live on."""
    mesh, space = tissue.bodies.mesh, tissue.space.vector
    trial = space.TrialFunction()
    form = ngsolve.BilinearForm(space)
    kept = []
    normal = ngsolve.specialcf.normal(2)
    along = ngsolve.CF((-normal[1], normal[0]))
    place = ngsolve.CF((ngsolve.x, ngsolve.y))
    tangent = along.Other() + ngsolve.Grad(trial).Trace().Other() * along.Other()
    outward = ngsolve.CF((tangent[1], -tangent[0])) / ngsolve.sqrt(tangent * tangent)
    gap = (place + trial - place.Other() - trial.Other()) * outward
    for primary, secondary in (("left", "right"), ("right", "left")):
        contact = ngsolve.ContactBoundary(mesh.Boundaries(primary), mesh.Boundaries(secondary))
        contact.AddEnergy(ngsolve.IfPos(gap, 0, STIFFNESS / 4 * gap * gap))
        contact.Update(field, form, intorder=2 * points - 1, maxdist=REACH)
        kept.append(contact)
    return form, kept


def on_facing_walls(tissue: SmallTissue, kinematics: GapKinematics) -> np.ndarray:
    """Which contact pairs are points of one of the two walls with a foot on the other."""
    middle = np.abs(tissue.walls.rest[:, :, 0] - np.sqrt(3) / 2).max(1) < 1e-9
    pairs = kinematics.pairs
    return middle[pairs.primary] & middle[pairs.secondary] & ~pairs.at_end


@pytest.mark.parametrize("order", [2, 3])
def test_closest_points_are_those_of_ngsolve_where_walls_are_apart(order):
    tissue = facing_cells(order)
    field = displaced(tissue, bent_out(0.03))
    mesh = tissue.bodies.mesh
    contact = ngsolve.ContactBoundary(mesh.Boundaries("left"), mesh.Boundaries("right"))
    contact.Update(field, maxdist=REACH)
    walls = with_gauss_points(tissue.walls, 3)
    positions = tissue.positions(field.vec.FV().NumPy())
    kinematics = PenaltyContact(walls, np.ones(walls.facet_count), REACH).pair(positions).kinematics
    from_left = np.flatnonzero(on_facing_walls(tissue, kinematics) & (walls.body[kinematics.pairs.primary] == 0))
    assert len(from_left) == 9
    away, _ = kinematics.vectors(positions)
    places = walls.places(kinematics.pairs.primary, kinematics.pairs.primary_xi, walls.rest)
    rule = ngsolve.IntegrationRule([(xi, 0, 0) for xi in walls.quadrature_points], [1.0] * 3)
    points = mesh.MapToAllElements({ngsolve.ET.SEGM: rule}, mesh.Boundaries("left"))
    theirs, height = contact.gap(points), ngsolve.y(points).ravel()
    ours = np.argsort(places[from_left, 1])
    np.testing.assert_allclose(places[from_left, 1][ours], np.sort(height), atol=1e-12)
    np.testing.assert_allclose(-away[from_left][ours], theirs[np.argsort(height)], atol=1e-8)
    gaps = np.linalg.norm(theirs[np.argsort(height)], axis=1)
    np.testing.assert_allclose(kinematics.gaps(positions)[from_left][ours], gaps, atol=1e-8)


@pytest.mark.parametrize(
    ("order", "shape"), [(1, shortened), (2, shortened), (2, bent_out), (3, bent_out)]
)  # at order 1 a sagitta would have kinks, where pairs differ
def test_energy_and_forces_are_those_of_the_symbolic_form(order, shape):
    tissue = facing_cells(order)
    field = displaced(tissue, shape(-0.005))
    walls = with_gauss_points(tissue.walls, order + 1)
    at = field.vec.FV().NumPy().copy()
    positions = tissue.positions(at)
    contact = PenaltyContact(walls, np.full(walls.facet_count, STIFFNESS), REACH).pair(positions)
    closed = contact.kinematics.gaps(positions) < 0
    assert closed.sum() > 3 and on_facing_walls(tissue, contact.kinematics)[closed].all()
    form, _kept = symbolic_contact(tissue, field, order + 1)
    assert contact.energy(positions) == pytest.approx(form.Energy(field.vec), rel=1e-9)
    force = field.vec.CreateVector()
    form.Apply(field.vec, force)
    gap, slopes, penalty = contact.penalty_terms(positions)
    ours = slopes.T @ (penalty * np.minimum(gap, 0))
    np.testing.assert_allclose(ours, force.FV().NumPy(), atol=1e-9 * np.abs(ours).max())


@pytest.mark.parametrize("order", [1, 2, 3])
def test_tangent_is_that_of_the_symbolic_form_on_straight_walls(order):
    """On curved walls ours has one term more: the contact pair follows."""
    tissue = facing_cells(order)
    field = displaced(tissue, shortened(-0.005))
    walls = with_gauss_points(tissue.walls, order + 1)
    positions = tissue.positions(field.vec.FV().NumPy())
    contact = PenaltyContact(walls, np.full(walls.facet_count, STIFFNESS), REACH).pair(positions)
    gap, slopes, penalty = contact.penalty_terms(positions)
    closed = slopes[np.flatnonzero(gap < 0)].toarray()
    ours = closed.T @ (penalty[gap < 0][:, None] * closed) + contact.curvature(positions).toarray()
    form, _kept = symbolic_contact(tissue, field, order + 1)
    form.AssembleLinearization(field.vec)
    np.testing.assert_allclose(ours, csr_matrix(form.mat).toarray(), atol=1e-9 * np.abs(ours).max())
