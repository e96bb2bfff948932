"""A lumen that closes touches itself: energies and derivatives, what is left out, and a cell pressed flat."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pytest
from scipy import sparse

from ngcell.build.simulation import Simulation
from ngcell.contact.methods.self_contact import SelfContact, self_contact_stages
from ngcell.contact.pairing.lumens import Closing
from ngcell.contact.surface.find_lumens import find_lumens
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.mechanics.term import OneSided, Role, Term
from ngcell.problem.problem import Problem
from ngcell.scene import read_case
from ngcell.solve.proximal import ProximalTerm
from tests.tissues import LAW, SmallTissue, small_tissue, whole_tangent

WALL = 0.2


def cell(*, order: int = 2, edges: int = 3, cells: int = 1) -> SmallTissue:
    """Hollow cells with level upper and lower walls, of which those of the first are held and moved."""
    sides = np.zeros((cells, 6), dtype=bool)
    supports = {}
    for name, sign in (("low", -1), ("high", 1)):
        supports[name] = sides.copy()
        supports[name][0, _level_side(sign)] = True
    return small_tissue(
        1, cells, order=order, edges=edges, wall=WALL, pointy=False, supports=supports,
        prescribed_displacement=(0.0, -1.0),
    )  # fmt: skip


def _level_side(sign: int) -> int:
    """The side of a hexagon whose middle lies straight below or above its centre."""
    corners = small_tissue(1, 1, pointy=False).lattice.outlines.corners[:6]
    middle = (corners + np.roll(corners, -1, axis=0)) / 2 - corners.mean(0)
    return int(np.argmax(sign * middle[:, 1]))


class Lumens:
    """The lumens of a tissue, and what keeps them from passing through themselves."""

    def __init__(self, tissue: SmallTissue) -> None:
        self.tissue = tissue
        found = find_lumens(tissue.bodies, tissue.space.scalar, tissue.space.rest)
        assert found is not None
        self.surface: LumenSurface = found

    @cached_property
    def term(self) -> SelfContact:
        modulus = np.full(self.tissue.bodies.body_count, LAW.plane_strain_modulus)
        (term,) = self_contact_stages(self.surface, modulus, 1)
        return term

    @cached_property
    def contact(self) -> Problem:
        """Contact within cells alone: bodies may be bent into anything."""
        return Problem(self.tissue.space, [self.term], self.tissue.motion.fixed)


def pressed(tissue: SmallTissue, by: float, wave: float = 0.03, seed: int = 3) -> np.ndarray:
    """A cell whose upper half comes down and whose lower half goes up, with bends."""
    x, y = tissue.space.rest * (tissue.space.one > 0)
    moved = tissue.smooth(wave, seed).reshape(2, -1)
    moved[1] -= by * np.tanh(8 * y) * tissue.space.one
    return moved.ravel()


@pytest.mark.parametrize("order", [1, 2, 3])
def test_forces_and_tangent_are_derivatives_of_one_energy(order):
    tissue = cell(order=order)
    problem, at = Lumens(tissue).contact, pressed(tissue, 0.68)
    state, way = problem.at(at), tissue.smooth(1.0, 8)
    step = 1e-7
    after, before = problem.at(at + step * way), problem.at(at - step * way)
    force = problem.gradient(state)
    assert state.energy > 0
    assert (after.energy - before.energy) / (2 * step) == pytest.approx(force @ way, rel=1e-5)
    bent = whole_tangent(problem, problem.linearise(state)) @ way
    change = (problem.gradient(after) - problem.gradient(before)) / (2 * step)
    np.testing.assert_allclose(change, bent, atol=1e-4 * np.abs(bent).max())


def test_forces_have_no_resultant_and_no_moment_and_are_none_between_bodies():
    tissue = cell()
    lumens = Lumens(tissue)
    state = lumens.contact.at(pressed(tissue, 0.68))
    force = lumens.contact.force(state.at, Role.INTERACTION).reshape(2, -1)
    x, y = tissue.positions(state.displacement)
    size = np.abs(force).sum()
    assert size > 0
    np.testing.assert_allclose(force @ tissue.space.one, 0, atol=1e-12 * size)
    assert x @ force[1] - y @ force[0] == pytest.approx(0, abs=1e-11 * size)
    assert lumens.term.interaction(state.at) is None
    (in_cell,) = lumens.term.force_in_bodies(state.at, 1)
    assert 0 < in_cell < size


def test_what_is_pressed_together_is_driven_apart():
    tissue = cell()
    lumens = Lumens(tissue)
    force = -lumens.contact.gradient(lumens.contact.at(pressed(tissue, 0.68, wave=0.0))).reshape(2, -1)
    is_upper = (tissue.space.rest[1] > 0) & (tissue.space.one > 0)
    assert force[1][is_upper].sum() > 0


@pytest.mark.parametrize("shear", [0.0, 0.3])
def test_an_open_lumen_has_no_contact_and_takes_no_room_in_the_matrix(shear):
    tissue = cell(cells=2)
    lumens = Lumens(tissue)
    at = tissue.space.affine(np.array([[0.0, shear], [0.0, 0.0]]), np.zeros(2)).ravel()
    state = lumens.contact.at(at + tissue.smooth(0.05, 2))
    assert state.energy == 0 and lumens.term.found(state.at) is None and lumens.term.constraints(state.at) is None
    row, column = lumens.term.couplings(state.at, 2 * WALL)
    assert len(row) == 1 and row == column


def hinged(tissue: SmallTissue, angle: float) -> np.ndarray:
    """A cell whose right half turns about a corner of its lumen, near which the two walls close by an angle."""
    x, y = tissue.space.rest
    one = tissue.space.one > 0
    inner = Lumens(tissue).surface.rest[:, 0]
    corner = inner[np.argmax(inner[:, 1])]
    away = np.array([x, y])[:, one] - corner[:, None]
    turned = np.clip(np.arctan2(away[0], -away[1]) / np.radians(60), -1, 1) * -angle / 2
    moved = np.zeros((2, tissue.space.size))
    moved[0, one] = np.cos(turned) * away[0] - np.sin(turned) * away[1] - away[0]
    moved[1, one] = np.sin(turned) * away[0] + np.cos(turned) * away[1] - away[1]
    return moved.ravel()


def test_a_corner_that_closes_like_a_hinge_touches_itself():
    tissue = small_tissue(1, 1, order=2, edges=6, wall=0.1)
    lumens = Lumens(tissue)
    term = lumens.term
    for angle in (0.0, 60.0):
        assert term.found(lumens.contact.at(hinged(tissue, np.radians(angle))).at) is None
    for angle in (100.0, 119.0):
        assert term.found(lumens.contact.at(hinged(tissue, np.radians(angle))).at) is not None
    assert lumens.contact.at(hinged(tissue, np.radians(110.0))).energy == 0
    assert lumens.contact.at(hinged(tissue, np.radians(130.0))).energy > 0


def test_lumens_of_two_cells_have_nothing_to_do_with_each_other():
    tissue = cell(cells=2)
    lumens = Lumens(tissue)
    at = tissue.body_translation(1, tissue.lattice.centres[0] - tissue.lattice.centres[1])
    assert lumens.contact.at(at).energy == 0


def test_what_was_seen_before_does_not_choose_which_lumens_close():
    tissue = cell(cells=2)
    lumens = Lumens(tissue).surface
    closing, seen = Closing(lumens), []
    for step in range(40):
        bend = 0.8 * np.sin(0.4 * step)
        at = pressed(tissue, bend, seed=step % 3) + tissue.body_translation(1, np.array([5.0, step]))
        nodes = lumens.nodes(tissue.positions(at))
        for reach in (0.0, 0.3):
            mine = closing.lumens(nodes, reach)
            np.testing.assert_array_equal(mine, Closing(lumens).lumens(nodes, reach))
            seen.append(mine.tolist())
    assert [False, False] in seen and any(map(any, seen))


def test_nobody_looks_again_at_lumens_that_move_as_rigid_bodies(monkeypatch):
    tissue = cell(cells=2)
    lumens, looks = Lumens(tissue).surface, []
    room_across = LumenSurface.room_across
    monkeypatch.setattr(LumenSurface, "room_across", lambda *given: looks.append(1) or room_across(*given))
    closing = Closing(lumens)
    nodes = lumens.nodes(tissue.positions(tissue.smooth(0.05, 2)))
    for angle in np.linspace(0, 6, 20):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        assert not closing.lumens(nodes @ turn + 3 * angle).any()
    assert len(looks) == 1
    assert closing.lumens(lumens.rest * np.array([1.0, 0.1])).all()
    assert len(looks) == 2


@pytest.mark.parametrize("flattened", [1.0, 0.6, 0.3])
def test_room_across_a_lumen_is_that_of_its_nearest_walls(flattened):
    lumens = Lumens(cell(cells=2, edges=8)).surface
    nodes = lumens.rest * np.array([1.0, flattened])
    corners = lumens.rest[lumens.body == 0][:, 0]  # of edges, and points between them
    corners = corners[np.argsort(np.arctan2(*(corners - corners.mean(0)).T))]
    ahead = np.roll(corners, -1, axis=0) - corners
    outline = np.concatenate([corners + share * ahead for share in (0.0, 0.25, 0.5, 0.75)])
    outline = outline[np.argsort(np.arctan2(*(outline - outline.mean(0)).T))]
    steps = np.linalg.norm(np.roll(outline, -1, 0) - outline, axis=1)
    way = np.abs(np.subtract.outer(np.cumsum(steps), np.cumsum(steps)))
    is_far = np.minimum(way, steps.sum() - way) >= min(6 * WALL, steps.sum() / 4)
    flat = outline * np.array([1.0, flattened])
    nearest = np.linalg.norm(flat[:, None] - flat, axis=2)[is_far].min()
    room = lumens.room_across(lumens.points(nodes), 2.0)
    np.testing.assert_allclose(room, nearest - WALL, atol=0.05)
    np.testing.assert_array_equal(lumens.room_across(lumens.points(lumens.rest), 0.1), [0.1, 0.1])


def test_lumens_share_nothing_with_outer_walls():
    tissue = small_tissue(1, 1)
    lumens = Lumens(tissue).surface
    assert lumens.body_of_loop.tolist() == [0]
    assert lumens.facet_count == 12 and not np.isin(lumens.dofs, tissue.walls.dofs).any()


def test_only_neighbours_on_a_side_are_left_out_of_a_hexagonal_lumen():
    lumens = Lumens(cell(edges=4)).surface
    one, two = (part.ravel() for part in np.indices((lumens.facet_count,) * 2))
    may = lumens.may_touch(one, two).reshape(lumens.facet_count, -1)
    np.testing.assert_array_equal(may, may.T)
    ahead = np.arange(lumens.facet_count)
    beside = lumens.neighbours[:, 1], lumens.neighbours[:, 0]
    assert not may[ahead, ahead].any()
    # Of the four edges of a side one neighbour at each end lies around a corner, and may touch.
    for neighbour in beside:
        assert may[ahead, neighbour].sum() == 6


class Plane(Term):
    """Two rigid planes in one: the upper and the lower half of a cell may not cross the line between them."""

    def __init__(self, tissue: SmallTissue, lumens: LumenSurface, stiffness: float) -> None:
        points = lumens.quadrature
        side = np.sign(lumens.places(points.facet, points.xi, lumens.rest)[:, 1])
        trace, size = lumens.trace(points.facet, points.xi), tissue.space.size
        rows = np.repeat(np.arange(len(side)), trace.shape[1])
        columns = lumens.dofs[points.facet].ravel() + size
        slopes = sparse.csr_array((trace.ravel(), (rows, columns)), shape=(len(side), 2 * size))
        chosen = np.flatnonzero(side)
        self.slopes = slopes[chosen] * side[chosen, None]
        self.penalty, self.side, self.level = stiffness * points.weight[chosen], side[chosen], 0.0

    def apply(self, load_factor):
        self.level = -load_factor / 2  # the lower support is held, the upper one comes down

    def value(self, at):
        return float(self.penalty @ np.minimum(self._gaps(at), 0) ** 2 / 2)

    def gradient(self, at):
        return np.zeros(at.positions.size)

    def constraints(self, at):
        return OneSided(self._gaps(at), self.slopes.tocsr(), self.penalty, np.arange(len(self.penalty)))

    def _gaps(self, at):
        return self.slopes @ at.positions.ravel() - self.side * self.level


def flattened(tissue: SmallTissue, problem: Problem) -> list[tuple[float, float]]:
    """Energy, and force of the supports, as a cell is pressed flat."""
    minimiser, displacement, found = tissue.minimiser(problem), np.zeros(tissue.space.unknowns), []
    minimiser.longest_step = WALL / 2
    motion, before = tissue.motion, 0.0
    for load in (0.3, 0.6, 0.9, 1.1, 1.2, 1.3, 1.33):
        for term in problem.terms:
            term.apply(load)
        start = motion.imposed(displacement + motion.lifting(load) - motion.lifting(before), load)
        minimum = minimiser.minimise(start, ProximalTerm(0.0, start))
        assert minimum.is_found
        displacement, before = minimum.state.displacement, load
        force = problem.gradient(minimum.state) * ~problem.free
        found.append((minimum.state.energy, float(np.abs(force.reshape(2, -1)[1]).sum() / 2)))
    return found


def test_a_cell_pressed_flat_is_two_halves_on_a_rigid_plane():
    """The oracle shares nothing with the search: it knows the plane of symmetry."""
    tissue = cell(edges=2)
    lumens = Lumens(tissue)
    pairwise = 2 * float(lumens.term.method.stiffness[0])  # walls that overlap by 2 y store as much as two planes
    touching = Problem(tissue.space, [tissue.bulk, lumens.term], tissue.motion.fixed)
    halves = Problem(tissue.space, [tissue.bulk, Plane(tissue, lumens.surface, pairwise)], tissue.motion.fixed)
    free = Problem(tissue.space, [tissue.bulk], tissue.motion.fixed)
    found, expected, without = (flattened(tissue, problem) for problem in (touching, halves, free))
    np.testing.assert_allclose(found, expected, rtol=1e-4)
    assert found[-1][1] > 1.1 * without[-1][1]


def test_the_stiffness_that_a_case_gives_acts_within_lumens_too():
    lumens, modulus = Lumens(cell()).surface, np.array([LAW.plane_strain_modulus])
    usual, stiff = (self_contact_stages(lumens, modulus, 2, stiffness=factor) for factor in (1.0, 3.0))
    ratios = [two.method.stiffness / one.method.stiffness for one, two in zip(usual, stiff, strict=True)]
    np.testing.assert_allclose(ratios[0], 1.0)
    np.testing.assert_allclose(ratios[1], 3.0)
    case = read_case("crush-3x3", ["contact.stiffness=3.0"])
    mine, derived = (Simulation(each)._self_contact(2)[-1].method.stiffness for each in (case, read_case("crush-3x3")))
    np.testing.assert_allclose(mine, 3.0 * derived)


def test_a_point_has_a_gap_to_each_side_that_it_has_a_foot_on():
    """In a lumen that has shrunk and sheared all sides are near: a point has feet on some; corners are no contact."""
    tissue = cell(edges=4)
    lumens = Lumens(tissue)
    surface, part = lumens.surface, lumens.surface.part
    shrunk = tissue.space.affine(np.array([[-0.9, 0.1], [0.0, -0.95]]), np.zeros(2)).ravel()
    state = lumens.contact.at(shrunk)
    found = lumens.term.found(state.at)
    assert found is not None
    pairs, nodes = found.kinematics.pairs, surface.nodes(state.at.positions)
    points = surface.quadrature
    place = surface.places(points.facet, points.xi, nodes)
    listed = set(zip(pairs.point.tolist(), part[pairs.secondary].tolist(), strict=True))
    expected = set()
    for side in np.unique(part):
        ends = nodes[part == side][:, [0, -1]].reshape(-1, 2)
        apart = np.linalg.norm(ends[:, None] - ends, axis=2)
        first, last = ends[list(np.unravel_index(apart.argmax(), apart.shape))]
        share = (place - first) @ (last - first) / apart.max() ** 2
        is_foot = (part[points.facet] != side) & (share > 1e-6) & (share < 1 - 1e-6)
        expected |= {(point, int(side)) for point in np.flatnonzero(is_foot).tolist()}
    assert listed == expected
    assert len(np.unique(found.keys)) == len(pairs) > len(np.unique(pairs.point))


@pytest.mark.parametrize("strategy", ["sddp", "single-step"])
def test_penalty_terms_of_a_cell_that_is_alone_adapt_by_each_strategy(strategy):
    one = ["tissue.rows=1", "tissue.cols=1", "accuracy=inf", "expected=[]", f"strategy.kind='{strategy}'"]
    case = read_case("shear-empty-3x3", [*one, "load={kind='plates', displacement=[0.0, -0.1], levels=1}"])
    simulation = Simulation(case)
    assert list(simulation.accepted_steps())
    (contact,) = (term for term in simulation.problem.terms if isinstance(term, SelfContact))
    assert contact.method.memory()
