"""The gap of a pair and its derivatives, for feet of normals and for ends of edges."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.terms import ContactTerm
from tests.tissues import SmallTissue, rotation, small_tissue

STEPS = np.array([2e-3, 1e-3, 5e-4])


def bent_pair(order: int, depth: float, dent: float = 0.0, aside: float = 0.2) -> tuple[SmallTissue, np.ndarray]:
    """Two bent cells, the right one pressed into the left one and aside, and their displacement.

    Each of them has the middle node of the wall between them moved in by `dent`.
    """
    tissue = small_tissue(1, 2, order=order, edges=2)
    x, y = tissue.space.rest
    middle = tissue.space.one * (np.hypot(x - np.sqrt(3) / 2, y) < 1e-6)
    inward = np.where(tissue.space.body_of_unknown == 0, -dent, dent) * middle
    dented = np.concatenate([inward, 0 * inward])
    return tissue, tissue.smooth(0.03, 3) + dented + tissue.body_translation(1, np.array([-depth, aside]))


def paired(tissue: SmallTissue, displacement: np.ndarray, *, fades: bool = False) -> GapKinematics:
    contact = PenaltyContact(tissue.walls, np.ones(tissue.walls.facet_count), reach=0.6, single_pass_corners=fades)
    return contact.pair(tissue.positions(displacement)).kinematics


def rates(remainders: list[float]) -> np.ndarray:
    return np.log2(np.array(remainders[:-1]) / remainders[1:])


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize(
    ("place", "at_end", "closed"),
    [((0.1,), False, True), ((-0.1,), False, False), ((0.3, 0.1, 0.0), True, True), ((-0.1,), True, False)],
    ids=["closed foot", "open foot", "closed end", "open end"],
)
def test_taylor_remainders_of_gaps_vanish_at_their_rates(order, place, at_end, closed):
    tissue, displacement = bent_pair(order, *place)
    kinematics = paired(tissue, displacement)
    at, size = tissue.positions(displacement), tissue.space.size
    gap, slopes = kinematics.slopes(at)
    np.testing.assert_array_equal(gap, kinematics.gaps(at))
    is_meant = (kinematics.pairs.at_end == at_end) & ((gap < 0) == closed) & (np.abs(gap) > 0.01)
    chosen = np.flatnonzero(is_meant)
    assert len(chosen)
    way = tissue.smooth(1.0, 9)
    slope = (kinematics.jacobian(slopes, size) @ way)[chosen]
    blocks = kinematics.curvatures(at, chosen)
    bend = [way @ (kinematics.assemble(blocks[[i]], chosen[[i]], size) @ way) for i in range(len(chosen))]
    frozen, first, second = [], [], []
    for step in STEPS:
        held = kinematics.gaps(at + step * way.reshape(2, -1))[chosen]
        frozen.append(np.abs(held - gap[chosen] - step * slope).max())
        followed = gaps_of_pairs(tissue, displacement + step * way, kinematics, chosen)
        first.append(np.abs(followed - gap[chosen] - step * slope).max())
        second.append(np.abs(followed - gap[chosen] - step * slope - step**2 / 2 * np.array(bend)).max())
    np.testing.assert_allclose(rates(frozen), 2, atol=0.2)
    np.testing.assert_allclose(rates(first), 2, atol=0.2)
    assert (rates(second) > 2.7).all()


@pytest.mark.parametrize("order", [1, 2, 3])
def test_faded_gaps_have_the_derivatives_of_their_factor(order):
    tissue, displacement = bent_pair(order, 0.1, 0.0, 0.2)
    kinematics = paired(tissue, displacement, fades=True)
    at, size = tissue.positions(displacement), tissue.space.size
    gap, slopes = kinematics.slopes(at)
    whole = kinematics.gap.gap.gaps(kinematics.pairs, kinematics.side, kinematics.correction, *kinematics.vectors(at))
    fading = np.abs(gap / whole - 1) > 0.05
    chosen = np.flatnonzero(fading & (np.abs(gap / whole) > 0.05) & ~kinematics.pairs.at_end & (gap < -1e-3))
    assert len(chosen) > 1
    way = tissue.smooth(1.0, 9)
    slope = (kinematics.jacobian(slopes, size) @ way)[chosen]
    blocks = kinematics.curvatures(at, chosen)
    bend = [way @ (kinematics.assemble(blocks[[i]], chosen[[i]], size) @ way) for i in range(len(chosen))]
    steps = 0.1 * np.array(STEPS)
    first, second = [], []
    for step in steps:
        followed = gaps_of_pairs(tissue, displacement + step * way, kinematics, chosen, fades=True)
        first.append(np.abs(followed - gap[chosen] - step * slope).max())
        second.append(np.abs(followed - gap[chosen] - step * slope - step**2 / 2 * np.array(bend)).max())
    np.testing.assert_allclose(rates(first), 2, atol=0.3)
    if order == 1:
        assert (rates(second) > 2.6).all()
    else:  # the curvature of the secondary wall is frozen
        assert second[-1] < 0.1 * first[-1]


def test_a_corner_slides_along_a_wall_without_bumps():
    tissue, bumps = small_tissue(1, 2, edges=9), {}
    space, centre = tissue.space, tissue.lattice.centres[1]
    turn = rotation(0.5)
    turned = (space.affine(turn - np.eye(2), centre - turn @ centre) * (space.body_of_unknown == 1)).ravel()
    at = tissue.positions(turned)[:, : space.mesh.nv]
    body = space.body_of_unknown[: space.mesh.nv]
    inward = at[0, body == 0].max() - at[0, body == 1].min() - 2e-3  # so deep is the corner in the wall
    for fades in (True, False):
        contact = PenaltyContact(tissue.walls, np.ones(tissue.walls.facet_count), reach=0.3, single_pass_corners=fades)
        energies = []
        for aside in np.linspace(-0.1, 0.1, 201):
            positions = tissue.positions(turned + tissue.body_translation(1, np.array([inward, aside])))
            energies.append(contact.pair(positions).energy(positions))
        assert min(energies) > 0
        bumps[fades] = np.ptp(energies) / np.mean(energies)
        deeper, higher = (
            contact.pair(at).energy(at)
            for at in (
                tissue.positions(turned + tissue.body_translation(1, np.array([by, 0.0])))
                for by in (inward - 1e-6, inward + 1e-6)
            )
        )
        acting = ContactTerm(contact).interaction(
            tissue.space.configuration(turned + tissue.body_translation(1, np.array([inward, 0.0])))
        )
        if fades:  # all of it is the corner's own force
            assert acting.normal.sum() == pytest.approx(abs(higher - deeper) / 2e-6, rel=1e-3)
    assert bumps[True] < 0.01 < 0.2 < bumps[False]


def gaps_of_pairs(
    tissue: SmallTissue, displacement: np.ndarray, before: GapKinematics, chosen: np.ndarray, *, fades: bool = False
) -> np.ndarray:
    """Gaps of the same points to the same bodies, with the contact pairs found anew."""
    kinematics = paired(tissue, displacement, fades=fades)
    pairs, known = kinematics.pairs, before.pairs
    where = {key: number for number, key in enumerate(zip(pairs.primary, pairs.primary_xi, strict=True))}
    same = [where[known.primary[number], known.primary_xi[number]] for number in chosen]
    return kinematics.gaps(tissue.positions(displacement))[same]


@pytest.mark.parametrize("distance", [0.05, -0.05])
def test_gaps_are_positive_between_walls_apart_and_negative_where_they_overlap(distance):
    tissue = small_tissue(1, 2)
    translation = tissue.body_translation(1, np.array([distance, 0.0]))
    kinematics = paired(tissue, translation)
    x, y = tissue.walls.places(kinematics.pairs.primary, kinematics.pairs.primary_xi, tissue.walls.rest).T
    between = (np.abs(x - np.sqrt(3) / 2) < 1e-9) & (np.abs(y) < 0.4)
    assert set(tissue.walls.body[kinematics.pairs.primary[between]]) == {0, 1}
    np.testing.assert_allclose(kinematics.gaps(tissue.positions(translation))[between], distance, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("depth", [0.1, -0.1])
def test_contact_pairs_are_closest_points(order, depth):
    tissue, displacement = bent_pair(order, depth)
    kinematics = paired(tissue, displacement)
    pairs, walls = kinematics.pairs, tissue.walls
    at = tissue.positions(displacement)
    away, tangent = kinematics.vectors(at)
    distance = np.linalg.norm(away, axis=1)
    lengths = np.maximum(distance, 1e-9) * np.linalg.norm(tangent, axis=1)
    feet = ~pairs.at_end
    assert (np.abs(np.einsum("nd,nd->n", away, tangent)) / lengths)[feet].max() < 1e-6
    np.testing.assert_allclose(np.abs(kinematics.gaps(at)), distance, rtol=1e-9, atol=1e-14)
    # By brute force: no point of the other body's walls is nearer.
    outline = walls.basis.values(np.linspace(0, 1, 201)) @ walls.nodes(at)
    own = walls.places(pairs.primary, pairs.primary_xi, walls.nodes(at))
    for body in (0, 1):
        mine = walls.body[pairs.primary] == body
        theirs = outline[walls.body != body].reshape(-1, 2)
        nearest = np.linalg.norm(own[mine][:, None] - theirs, axis=2).min(1)
        assert (distance[mine] <= nearest + 1e-12).all()
        np.testing.assert_allclose(distance[mine], nearest, atol=1e-2)
