"""Unilateral contact by a mortar method: the contact pressure is an unknown, and arises without any overlap.

For each function psi of the multiplier space on one wall of a pair, with integrals over the wall at rest,

    gap_psi = integral psi g / integral psi >= 0,   pressure_psi >= 0,   pressure_psi gap_psi = 0.

One body of each pair has the multiplier: the softer, then the finer one. Integrals are taken segment by segment, in
three dimensions over intersection polygons, whose points are found where pressures are updated and stay in between.

A weighted gap does not notice where a corner, or two walls bent towards each other, sink in between its points: there
the pressure is a point force, which no polynomial represents. So the vertices of both walls and the quarters of their
facets are constrained, too. Each of these point constraints has a multiplier of its own, which acts once the point is
deeper than an allowance: a share of its facet's size (`ContactOptions.allowed`), plus the sagitta of the surface at
rest. Surfaces of order 1 are polygons that stand for what bends; their sagitta is also taken where the continuation
hands over to the mortar method. The allowance falls with the mesh; it keeps point constraints out of smooth contact,
where they would take pressure from walls.

Where the end of another wall covers hardly anything of what a function acts on, its multiplier would be determined by a
sliver: large, for a force of nothing, and a wall that slides back from the sliver gains by it. There a function has no
multiplier, only its penalty term, until more is covered (`ContactOptions.covered`).

Between two edges at a concave joint a point comes to rest where its gap has a kink: there both edges hold it, each with
a multiplier (`ngcell.contact.methods.notches`).

Conditions are met by the method of multipliers, a proximal form of the semismooth Newton (primal-dual active set)
method: penalty terms ``stiffness min(0, gap - pressure / stiffness)^2 / 2`` have, at fixed pressures, an energy that
the solver descends; the pressures of the penalty terms then become the new multipliers, until nothing changes. Penalty
terms only set the pace: each update leaves a share of the gaps that is about the walls' own stiffness over theirs, and
where it leaves most they are stiffened. Multipliers begin with pressures whose forces are those of the penalty that led
there; a point that is no deeper than its allowance has none, since its gap is open. Where the penalty had to become
stiffer, since walls are confined, terms begin as much stiffer as it would be were it meant to last. Near an equilibrium
multipliers are foreseen by the solver (`ngcell.solve.foreseen`).

Why this variant. Multipliers that are continuous and one order lower than the trace are stable beside it for any mesh
of the other body, and Bernstein polynomials keep pressures positive; dual multipliers only pay where multipliers are
eliminated, which penalty terms do already. Segments, because a rule that ignores the other mesh misses the patch test
by the jumps it steps over. Integrals at rest, so that weights do not move. Each wall has multipliers of its own, broken
at sharp corners, so three cells that meet at a corner have three conditions on six unknowns and none twice.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.by_surface import gap_kinematics
from ngcell.contact.gap.moving_ends import Cuts
from ngcell.contact.methods.integration import integration, rule_of_ends, wall_ends
from ngcell.contact.methods.mortar_set import MortarSet
from ngcell.contact.methods.multipliers import MultiplierSpace, constrained_points, sagitta
from ngcell.contact.methods.notches import Notches, extended
from ngcell.contact.methods.pressures_alike import nodal_forces, pressures_alike
from ngcell.contact.methods.protocol import Adapting, ContactMethod, ContactSet
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach, adjacency, facing
from ngcell.contact.pairing.pairs import ContactPairs, joined
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.pairing.segments import SegmentEnds
from ngcell.contact.pairing.wall_ends import WallEnds
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import Surface, SurfacePoints
from ngcell.mechanics.stored import StoredEnergy

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: By how much penalty terms are stiffened where updates are slow, and at most in all.
PENALTY_INCREASE, MOST_INCREASE = 10.0, 1e4


class MortarContact:
    """Mortar contact between all walls.

    Parameters
    ----------
    walls : Surface
        The walls.
    stiffness : array of float, shape (facets,)
        Stiffness of the penalty terms of each facet [stress / length]; it sets the pace, not the result.
    reach : float or array of float, shape (bodies,)
        Distance up to which walls are paired [length].
    options : ContactOptions
        The solver's own numbers.
    """

    has_multipliers = True

    def __init__(
        self, walls: Surface, stiffness: Array, reach: Reach, options: ContactOptions = DEFAULT_OPTIONS
    ) -> None:
        self.walls, self._options = walls, options
        self.stiffness = stiffness
        self.reach = reach
        self.space = MultiplierSpace(walls)
        self._rank = _softer_first(walls, stiffness)
        self._integration = integration(walls, reach, self._rank, options.facing)
        constrained = constrained_points(walls)
        self._constrained_facet, self._bodies = constrained.facet, int(walls.body.max()) + 1
        self._constrained, self._notches = PairSearch(walls, constrained, reach), Notches(walls, constrained)
        self._allowance = self._allowed(walls.rest)
        self._weight = self._all_rows(self.space.weight, walls.depth[constrained.facet] ** (walls.dimension - 1))
        self._stiffness = self._of_facets(stiffness)
        self.multipliers, self._missed = np.zeros((2, len(self._weight)))
        self._pace = np.ones_like(self._weight)

    def _allowed(self, nodes: Array) -> Array:
        """Return what is added to the gaps of point constraints; the sagitta of polygons grows where they bend."""
        rise = sagitta(self.walls, self.walls.rest)
        if self.walls.basis.order == 1:
            rise = np.maximum(rise, sagitta(self.walls, nodes))
        allowance = self._options.allowed * self.walls.sizes + rise
        return self._all_rows(np.zeros(self.space.size), allowance[self._constrained_facet])

    def _all_rows(self, by_function: Array, by_point: Array) -> Array:
        """Return values of all multipliers: functions first, then each point constraint with each body, and with the
        second edge of a notch there."""
        by_body = np.repeat(by_point, self._bodies)
        return np.concatenate([by_function, by_body, by_body])

    def _of_facets(self, values: Array) -> Array:
        """Return values of all multipliers, from those of the facets that they act on."""
        by_function = np.zeros(self.space.size)
        by_function[self.space.row] = values[:, None]
        return self._all_rows(by_function, values[self._constrained_facet])

    def follow(self, other: ContactMethod, positions: Array) -> None:
        """Start from pressures, of all conditions that overlap somewhere, whose forces are those of another method at
        its equilibrium."""
        nodes = self.walls.nodes(positions)
        self._integration.renew(nodes)
        self._allowance = self._allowed(nodes)
        self._pace, self.multipliers = np.ones_like(self._weight), np.zeros_like(self._weight)
        if isinstance(other, Adapting):
            raised, further = other.raised_on_facets, self._options.stored_before / self._options.stored
            raised = np.where(raised > 1, further * raised, raised)
            self._pace = self._of_facets(raised)
        self._notches.clear()
        theirs, mine = other.pair(positions), self.pair(positions)
        _, jacobian, _ = mine.penalty_terms(positions)
        is_deep = mine.kinematics.gaps(positions) + mine.average.T @ mine.allowance < 0
        overlaps = np.flatnonzero(mine.average @ is_deep)
        pulled = (sparse.diags_array(mine.weight[overlaps]) @ jacobian[overlaps]).T.tocsc()
        self.multipliers[mine.rows[overlaps]] = pressures_alike(pulled, nodal_forces(theirs, positions))

    def pair(self, positions: Array) -> MortarSet:
        """Find all points of the rule and point constraints at `positions`, shape (dimension, scalar unknowns)."""
        nodes = self.walls.nodes(positions)
        along, ends = self._integration.points(nodes)
        constrained = self._notches.pairs(self._constrained.pairs(nodes), nodes)
        pairs, held = joined([along, constrained]), len(along) + self._notches.held(constrained)
        rows, average = self._averages(along, constrained)
        return MortarSet(
            kinematics=extended(self.walls, pairs, positions, held),
            cuts=None if ends is None else self._cuts(ends, along, rows, positions, nodes),
            rows=rows,
            average=average,
            allowance=self._allowance[rows],
            pressure=self.multipliers[rows],
            stiffness=(self._pace * self._stiffness)[rows],
            weight=self._weight[rows],
            is_covered=average.sum(1) >= self._options.covered,
        )

    def _point_row(self, point: Index, body: Index) -> Index:
        return self.space.size + point * self._bodies + body

    @cached_property
    def _ends(self) -> WallEnds:
        assert isinstance(self.walls, EdgeSurface)  # others have no cuts
        return wall_ends(self.walls)

    def _cuts(self, ends: SegmentEnds, along: ContactPairs, rows: Index, positions: Array, nodes: Array) -> Cuts:
        ways, cuts = self._ends, ends.cuts
        projected = replace(cuts, primary_xi=ways.projected(cuts.primary, cuts.primary_xi))
        kinematics, before = (gap_kinematics(self.walls, pairs, positions) for pairs in (cuts, projected))
        of_rule = rule_of_ends(self.walls, self.space, ends, along, nodes)
        (slope,) = self.walls.tangents(projected.primary, projected.primary_xi, nodes)
        at = self._shares(cuts, rows), np.searchsorted(rows, self.space.row[cuts.primary]), ends.point
        return Cuts(kinematics, before, *at, *of_rule, slope, *ways.rates(cuts.primary, cuts.primary_xi))

    def _averages(self, along: ContactPairs, constrained: ContactPairs) -> tuple[Index, sparse.csr_array]:
        """Return the multipliers that have points, and the share of each point in their gaps."""
        point_row = self._point_row(constrained.point, self.walls.body[constrained.secondary])
        rows = np.unique(np.concatenate([self.space.row[along.primary].ravel(), point_row]))
        place = np.searchsorted(rows, point_row), np.arange(len(point_row))
        point_share = sparse.csr_array((np.ones(len(point_row)), place), shape=(len(rows), len(point_row)))
        return rows, sparse.hstack([self._shares(along, rows), point_share], format="csr")

    def _shares(self, points: ContactPairs, rows: Index) -> sparse.csr_array:
        """Return psi times the weight of each point over the integral of psi, shape (rows, points)."""
        row = self.space.row[points.primary]
        share = points.weight[:, None] * self.space.values(points.primary_xi) / self.space.weight[row]
        column = np.repeat(np.arange(len(points)), row.shape[1])
        place = np.searchsorted(rows, row.ravel()), column
        return sparse.csr_array((share.ravel(), place), shape=(len(rows), len(points)))

    def couplings(self, positions: Array, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of all scalar unknowns that contact could couple while nothing moves by more
        than half of `margin` [length]: those of all facets near the support of one multiplier."""
        near = adjacency(self.walls, self.walls.nodes(positions), self.reach + margin)
        row = self.space.row
        spread = sparse.csr_array(
            (np.ones(row.size), (row.ravel(), np.repeat(np.arange(len(row)), row.shape[1]))),
            shape=(self.space.size, len(row)),
        )
        reached = spread @ near @ self.walls.touches(positions.shape[1])
        reached.data[:] = 1
        row, column = (reached.T @ reached).tocoo().coords
        return row.astype(np.int64), column.astype(np.int64)

    def pressures(self, positions: Array, points: SurfacePoints) -> Array:
        """Return the contact pressure at points of the walls [stress]; that of a pair is the same on both its walls."""
        nodes = self.walls.nodes(positions)
        multipliers = self._applied(self.pair(positions), positions)[: self.space.size]
        pairs, body = PairSearch(self.walls, points, self.reach).pairs(nodes), self.walls.body
        has_multiplier = self._rank[body[pairs.primary]] < self._rank[body[pairs.secondary]]
        facet = np.where(has_multiplier, pairs.primary, pairs.secondary)
        on_primary = has_multiplier.reshape(-1, *(1,) * (pairs.primary_xi.ndim - 1))
        xi = np.where(on_primary, pairs.primary_xi, pairs.secondary_xi)
        pressure = (self.space.values(xi) * multipliers[self.space.row[facet]]).sum(1)
        faces = facing(self.walls, nodes, pairs.primary, pairs.secondary, self._options.facing)
        acts = faces & (has_multiplier | ~pairs.at_end)
        largest = np.zeros(len(points.facet))
        np.maximum.at(largest, pairs.point, np.where(acts, pressure, 0.0))
        return largest

    def update_multipliers(self, contact: ContactSet, positions: Array, stored: StoredEnergy) -> tuple[float, float]:
        """Take the pressures of an equilibrium as multipliers; return the largest gap [length] that their change stands
        for, and the energy of that change in penalty terms of the stiffness that they have at first
        [stress * length**2]: stiffer ones would count slivers of walls, which bear nothing."""
        assert isinstance(contact, MortarSet)
        if self._integration.renew(self.walls.nodes(positions)):
            contact = self.pair(positions)
        applied = self._applied(contact, positions)
        stiffness = self._pace * self._stiffness
        missed = np.abs(applied - self.multipliers) / stiffness
        self.multipliers = applied
        if self._leave_notches(contact, positions):
            again = self._applied(self.pair(positions), positions)
            missed = np.maximum(missed, np.abs(again - self.multipliers) / stiffness)
        self._missed = missed
        return float(missed.max(initial=0.0)), float((self._stiffness * self._weight * missed**2).sum()) / 2

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Take multipliers that are foreseen, by how much they lower gaps; keys are their numbers."""
        self.multipliers = self.multipliers.copy()
        self.multipliers[keys] = (self._pace * self._stiffness)[keys] * lowered

    def note_kinks(self, contact: ContactSet, positions: Array) -> bool:
        """Let points that press near a notch be held by both of its edges."""
        assert isinstance(contact, MortarSet)
        pressure, first = contact.pressures(positions), np.searchsorted(contact.rows, self.space.size)
        row = first + np.flatnonzero(pressure[first:])
        held = self._point_row(self._notches.point, self._notches.bodies)
        number = contact.rows[row]
        new = (number < self.space.size + len(self._constrained_facet) * self._bodies) & ~np.isin(number, held)
        row, number = row[new], number[new] - self.space.size
        edge = contact.kinematics.pairs.secondary[contact.average.indices[contact.average.indptr[row]]]
        return self._notches.found(number, number // self._bodies, edge, positions)

    def _leave_notches(self, contact: MortarSet, positions: Array) -> bool:
        """Release points that one edge of a notch alone holds; its pressure is that of the point then."""
        if not len(self._notches):
            return False
        first = self._point_row(self._notches.point, self._notches.bodies)
        rows = np.column_stack([first, first + len(self._constrained_facet) * self._bodies])
        far, pressed = ~np.isin(rows[:, 1], contact.rows), self.multipliers[rows] / (self._pace * self._stiffness)[rows]
        rows = rows[self._notches.left(far, pressed, positions)]
        self.multipliers[rows[:, 0]] += self.multipliers[rows[:, 1]]
        self.multipliers[rows[:, 1]] = 0
        return len(rows) > 0

    def increase_penalty(self) -> None:
        """Stiffen the penalty terms that have missed most: the stiffness of confined walls is more than they were made
        for."""
        slow = self._missed > self._missed.max(initial=0.0) / PENALTY_INCREASE
        increased = np.minimum(PENALTY_INCREASE * self._pace[slow], MOST_INCREASE)
        self._pace[slow] = np.maximum(self._pace[slow], increased)

    def _applied(self, contact: MortarSet, positions: Array) -> Array:
        applied = np.zeros_like(self.multipliers)
        applied[contact.rows] = contact.multipliers(positions)
        return applied


def _softer_first(walls: Surface, stiffness: Array) -> Index:
    """Return the rank of each body: of a pair, the one with the lower rank has the multiplier."""
    count = int(walls.body.max()) + 1
    softness, size = np.full(count, np.inf), np.zeros(count)
    np.minimum.at(softness, walls.body, stiffness * walls.depth)
    np.add.at(size, walls.body, walls.sizes)
    size /= np.maximum(np.bincount(walls.body, minlength=count), 1)
    order = np.lexsort((np.arange(count), np.round(size / size.max(), 9), np.round(np.log(softness), 9)))
    rank = np.empty(count, dtype=np.int64)
    rank[order] = np.arange(count)
    return rank
