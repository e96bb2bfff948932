"""Which equilibrium is meant: the continuation path.

Released cells may float, and their corners may pass each other on either side: equilibria of the energy E are not
unique, not even in energy. The one that is meant is the end of the path of minima of

    E(u) + weight/2 |u - centre|^2        (mass norm)

from a strong proximal term to a vanishing one. It is a release by a ramp: the proximal term gives the walls free little by little.
The path starts at the minimum without contact, which is unique under a strong proximal term: at the centre walls touch and
corners meet corners, and it is the forces in the walls, not the round-off of a start, that decide which way they part.
So the equilibrium follows from centre and energy alone, not from load steps or from where the continuation came from. In the
limit, floating cells sit as near to the centre as contact allows. What the last proximal term still holds is measured and
reported. Cells that hardly anything holds may cycle on corners of others without end: where the last stretch, from
`ENOUGH` to `LAST`, takes longer than the way to it, or stalls, the path ends at `ENOUGH`.

Numbers: the scale of the weight is shear modulus over cell size squared, which makes the continuation independent of units.
At ``FIRST`` the proximal term outweighs everything but the wall's own stiffness, and no pressure in the cells drives walls
through each other before there is contact; at ``LAST`` it is below every stiffness but that of floating cells. In
between it falls by `NARROWEST` decades a step, and by more where no wall closes or opens: a proximal term that falls
faster leaves the path where cells come free, and ends on another equilibrium.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.effort import Effort
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum, ProximalTerm
from ngcell.solve.problem import State

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

FIRST, ENOUGH, LAST = 1e3, 1e-7, 1e-9
#: Decades by which the proximal term falls from one minimisation to the next, at least and at most.
NARROWEST, WIDEST = 0.5, 1.0
#: Share of the longest step to which the place is rounded where a continuation begins.
LAST_DIGIT = 1e-6
#: Strength, in units of the scale, at which contact stiffens: walls have found their contact pairs there, and floating cells
#: are still held well enough to follow.
STIFFEN_AT = 1e-5
#: Decrement at which a minimisation along the path, and the last one, ends: shares of the proximal term's energy.
ON_THE_WAY, AT_THE_END = 0.01, 1e-10
#: Decrement at which a minimisation between updates of contact pressures ends: share of the energy that stands for what
#: conditions are missed by.
UPDATE = 0.1
#: Share of the longest step by which conditions of contact and fluids may be missed at the end, and the most updates
#: to get there.
CONDITION, MOST_UPDATES = 1e-12, 40
#: Iterations of one minimisation that are cycle, on the last stretch and between updates of conditions.
CYCLING = 200
#: Share of what was missed before above which an update was slow.
SLOW = 0.25
#: Share of the energy that is nothing: a decrement on the way, or what is missed where updates hardly help, as slivers
#: of walls bear nothing.
NOTHING = 1e-11


@dataclass(frozen=True, eq=False)
class _Enough:
    """Where a path may end if need be: a place, the weight of the proximal term there, and the iterations up to it."""

    place: Array
    weight: float
    way: int


@dataclass(frozen=True)
class Continuation:
    """The path's steps.

    Attributes
    ----------
    scale : float
        Shear modulus over squared size of a body [stress / length**2].
    first, last : float
        Strength at the start and at the end in units of `scale`.
    narrowest : float
        Decades by which the weight falls where walls close or open.
    """

    scale: float
    first: float = FIRST
    last: float = LAST
    narrowest: float = NARROWEST

    def select(
        self,
        apart: Minimiser,
        minimisers: Sequence[Minimiser],
        start: Array,
        centre: Array,
        *,
        may_stall: bool = True,
    ) -> Minimum:
        """Follow the path and return its end; a minimisation that fails ends the continuation.

        Parameters
        ----------
        apart : Minimiser
            Of the problem without contact.
        minimisers : sequence of Minimiser
            Of the released problem, with contact from soft to stiff: the path is followed with the first down to
            `STIFFEN_AT`, where the others take over one after the other, and to its end with the last.
        start, centre : array of float, shape (unknowns,)
            Where the continuation starts and where the proximal term pulls to [length].
        may_stall : bool
            Whether a minimisation may stall where the proximal term is still strong; what lies behind may be another
            equilibrium, and a smaller load step would not have come there.
        """
        # Down to round-off, and then cut, so that whatever the start, the continuation goes on from the same place.
        minimum, _ = _minimise(apart, start, self._proximal(self.first, centre), 0.0, self.first)
        for minimiser in minimisers:
            minimiser.forget_matrix()
        if not minimum.is_found:
            return minimum
        minimum, instead = self._follow(minimisers, minimum.state, centre, may_stall)
        if instead is None:
            return minimum
        _log.info("the path ends at %.0e", instead.weight)
        proximal, most = self._proximal(instead.weight, centre), max(CYCLING, instead.way)
        minimum, _ = _minimise(minimisers[-1], instead.place, proximal, AT_THE_END, instead.weight, most=most)
        if not minimum.is_found:
            return minimum
        return until_conditions_hold(minimisers[-1], minimum, minimisers[-1].longest_step, instead.weight)

    def _follow(
        self, minimisers: Sequence[Minimiser], start: State, centre: Array, may_stall: bool
    ) -> tuple[Minimum, _Enough | None]:
        """Return the last minimum of the continuation, and where the path may end instead, if its last stretch failed."""
        rest, weight, decades = list(minimisers), self.first, self.narrowest
        place, energy = _without_round_off(start.displacement, minimisers[0]), start.energy
        missed, way, enough = 0.0, 0, None
        while not (enough and way > 2 * enough.way):
            minimiser, is_end = rest[0], len(rest) == 1 and weight <= self.last
            if enough is None and len(rest) == 1 and self.last < weight <= ENOUGH:
                enough = _Enough(place, weight, way)
            share, least = (AT_THE_END, 0.0) if is_end else (ON_THE_WAY, NOTHING * abs(energy))
            least, most = max(UPDATE * missed, least), CYCLING if enough else None
            proximal = self._proximal(weight, centre)
            minimum, effort = _minimise(minimiser, place, proximal, share, weight, least, most)
            way += effort.iterations
            if minimum.ending is Ending.STALLED and weight > STIFFEN_AT and not may_stall:
                minimum = replace(minimum, ending=Ending.NO_DESCENT)
            if minimum.is_found and is_end:
                most = 2 * enough.way - way if enough else None
                minimum = until_conditions_hold(minimiser, minimum, minimiser.longest_step, weight, most)
                return minimum, None if minimum.ending is Ending.CONVERGED else enough
            if not minimum.is_found:
                break
            place, energy = minimum.state.displacement, minimum.state.energy
            _, missed = minimiser.problem.update_multipliers(minimum.state)
            if len(rest) > 1 and weight <= max(STIFFEN_AT, self.last):
                rest.pop(0)
                rest[0].problem.follow(minimiser.problem, minimum.state)
                rest[0].adopt_matrix(minimiser)
                continue
            # Longer and longer strides while no wall closes or opens.
            decades = min(2 * decades, WIDEST) if effort.factorisations <= 1 else self.narrowest
            milestone = max(STIFFEN_AT, self.last) if len(rest) > 1 else self.last
            weight = max(weight / 10**decades, milestone)
        return minimum, enough

    def last_proximal(self, centre: Array) -> ProximalTerm:
        """Return the proximal term at the path's end."""
        return self._proximal(self.last, centre)

    def _proximal(self, weight: float, centre: Array) -> ProximalTerm:
        """Return a proximal term of this weight in units of the scale."""
        return ProximalTerm(self.scale * weight, centre)


def until_conditions_hold(
    minimiser: Minimiser, minimum: Minimum, length: float, name: float = 0.0, most: int | None = None
) -> Minimum:
    """Update multipliers and minimise in turn until what is missed is nothing beside `length`.

    A continuation that cycles goes on for at most so many iterations.
    """
    before, was_increased, spent = float("inf"), False, minimiser.effort.iterations
    for _ in range(MOST_UPDATES):
        missed, energy = minimiser.problem.update_multipliers(minimum.state)
        helpless = was_increased and missed > before / 2 and energy <= NOTHING * abs(minimum.state.energy)
        if missed <= CONDITION * length or helpless:
            return minimum
        _log.info("conditions missed by %.1e", missed)
        was_increased = missed > SLOW * before
        if was_increased:
            minimiser.problem.increase_penalty()
        before = missed
        start, tolerance = minimum.state.displacement, UPDATE * energy
        minimum, _ = _minimise(minimiser, start, minimum.proximal, AT_THE_END, name, tolerance, CYCLING)
        if not minimum.is_found:
            return minimum
        cycles = minimum.ending is Ending.STALLED
        if cycles and most is not None and minimiser.effort.iterations - spent > most:
            break
    return replace(minimum, ending=Ending.CONDITIONS_MISSED)


def _without_round_off(place: Array, minimiser: Minimiser) -> Array:
    """Return a place where round-off says nothing of how it was reached: digits that no equilibrium depends on are cut.

    A nearly symmetric tissue chooses between branches by its last digits. From here the continuation is the same to the bit,
    whatever the start and the levels before.
    """
    digit = LAST_DIGIT * minimiser.longest_step
    return np.where(minimiser.problem.free, digit * np.round(place / digit), place)


def _minimise(
    minimiser: Minimiser,
    start: Array,
    proximal: ProximalTerm,
    share: float,
    name: float,
    enough: float = 0.0,
    most: int | None = None,
) -> tuple[Minimum, Effort]:
    before = minimiser.effort.copy()
    minimum = minimiser.minimise(start, proximal, max(share * minimiser.proximal_energy(start, proximal), enough), most)
    spent = minimiser.effort - before
    _log.info(
        "proximal term %.0e: %s, %d iterations, %d factorisations, %d refused, energy %.8e, decrement %.0e",
        name,
        minimum.ending.value,
        spent.iterations,
        spent.factorisations,
        spent.refusals,
        minimum.state.energy,
        minimum.decrement,
    )
    return minimum, spent
