"""Which equilibrium is meant: continuation in the weight of the proximal term.

Released cells may float, and their corners may pass each other on either side: equilibria of the energy E are not
unique, not even in energy. The one that is meant is the end of the path of minima of

    E(u) + weight/2 |u - centre|^2        (norm of the metric)

from a large weight to a vanishing one. It is a release by a ramp: the proximal term sets the walls free little by
little. The path starts at the minimum without contact, which is unique under a large weight: at the centre walls touch
and corners meet corners, and it is the forces in the walls, not the round-off of a start, that decide which way they
part. So the equilibrium follows from centre and energy alone, not from load steps or from where the bodies came from.
What the last proximal term still holds is measured and reported.

How the path ends depends on the accuracy that is asked for. Where it is finite, the path goes to `recentred`, and from
there each minimum is the centre of the next proximal term (`ngcell.solve.recentred`). Digits that nobody asked for,
such as the last ones of the places of floating cells, take most of the time on any other way. At accuracy inf the
centre stays, and in the limit floating cells sit as near to it as contact allows. They may cycle on corners of others
without end: where the last stretch, from `enough` to `last`, takes longer than the way to it, or stalls, the path ends
at `enough`.

Numbers (`ngcell.solve.options.ContinuationOptions`): the scale of the weight is shear modulus over cell size squared,
which makes the path independent of units. At `first` the proximal term outweighs everything, the stiffness of walls
included but for that against a change of volume, and no pressure in the cells drives walls through each other before
there is contact; at `last` it is below every stiffness but that of floating cells. In between it falls by `narrowest`
decades a step, and by more where no wall closes or opens: a weight that falls faster leaves the path where cells come
free, and ends on another equilibrium.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.balanced import in_balance
from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.problem import State
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.recentred import is_too_soft, minimised, recentred
from ngcell.solve.rested import led_to_rest, rested

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class _Enough:
    """Where a path may end if need be: a place, the weight of the proximal term there, and the iterations up to it."""

    place: Array
    weight: float
    way: int


@dataclass(frozen=True)
class Continuation:
    """The path.

    Attributes
    ----------
    scale : float
        Shear modulus over squared size of a body [stress / length**2].
    options : ContinuationOptions
        The method's own numbers; weights in units of `scale`.
    """

    scale: float
    options: ContinuationOptions = field(default_factory=ContinuationOptions)

    def begin(self, apart: Minimiser, start: Array, centre: Array) -> Minimum:
        """Return where the path begins: the minimum of the problem without contact, under the first weight.

        It goes down to round-off, so that the path does not depend on `start`; it sets out from the centre where that
        is lower.
        """
        proximal = self._proximal(self.options.first, centre)
        at_centre = np.where(apart.problem.free, centre, start)
        totals = [apart.total(apart.problem.at(place), proximal) for place in (start, at_centre)]
        lower = at_centre if totals[1] < totals[0] else start
        return minimised(apart, lower, proximal, 0.0, self.options.first)[0]

    def select(
        self, begin: State, minimisers: Sequence[Minimiser], centre: Array, *, may_stall: bool = True
    ) -> Minimum:
        """Follow the path and return its end; a minimisation that fails ends it.

        Parameters
        ----------
        begin : State
            Where the path begins.
        minimisers : sequence of Minimiser
            Of the released problem, with contact from soft to stiff: the first follows the path down to
            `stiffen_at`, where the others take over one after the other; the last goes to its end.
        centre : array of float, shape (unknowns,)
            The centre of the proximal term [length].
        may_stall : bool
            Whether a minimisation may stall where the proximal term is still strong; what lies behind may be another
            equilibrium, and a smaller load step would not have come there.
        """
        options = self.options
        for minimiser in minimisers:
            minimiser.forget_matrix()
        minimum, instead = self._follow(minimisers, begin, centre, may_stall)
        if instead is None:
            return minimum
        _log.info("the path ends at %.0e", instead.weight)
        proximal, most = self._proximal(instead.weight, centre), max(options.cycling, instead.way)
        last = minimisers[-1]
        minimum, _ = minimised(last, instead.place, proximal, options.at_the_end, instead.weight, most=most)
        if not minimum.is_found:
            return minimum
        minimum = until_conditions_hold(last, minimum, last.longest_step, options, name=instead.weight)
        return in_balance(last, minimum, self.scale, options)

    def _follow(
        self, minimisers: Sequence[Minimiser], start: State, centre: Array, may_stall: bool
    ) -> tuple[Minimum, _Enough | None]:
        """Return the last minimum, and where the path may end instead, if its last stretch failed."""
        options = self.options
        rest, weight, decades = list(minimisers), self.options.first, self.options.narrowest
        place = minimisers[0].rounded(start.displacement)
        magnitude = minimisers[0].problem.magnitude(start)
        missed, way, enough = 0.0, 0, None
        while not (enough and way > 2 * enough.way):
            minimiser, is_end = rest[0], len(rest) == 1 and weight <= options.end
            if enough is None and len(rest) == 1 and options.end < weight <= options.enough:
                enough = _Enough(place, weight, way)
            is_exact = is_end and not options.sufficient
            share, least = (options.at_the_end, 0.0) if is_exact else (options.on_the_way, options.nothing)
            least, most = max(options.update * missed, least * magnitude), options.cycling if enough else None
            proximal = self._proximal(weight, centre)
            minimum, effort = minimised(minimiser, place, proximal, share, weight, least, most)
            way += effort.iterations
            if minimum.ending is Ending.STALLED and weight > options.stiffen_at and not may_stall:
                minimum = replace(minimum, ending=Ending.NO_DESCENT)
            if minimum.is_found and is_end and options.sufficient:
                ends = replace(options, sufficient=max(options.sufficient, options.at_path_end))
                minimum = recentred(minimiser, minimum.state.displacement, minimum.proximal.weight, ends)
                if options.only_leads:
                    return led_to_rest(minimiser, minimum, self.scale, options, way), None
                return rested(minimiser, minimum, self.scale, options), None
            if minimum.is_found and is_end:
                most = 2 * enough.way - way if enough else None
                minimum = until_conditions_hold(
                    minimiser, minimum, minimiser.longest_step, options, name=weight, most=most
                )
                found = in_balance(minimiser, minimum, self.scale, options)
                return found, None if found.ending is Ending.CONVERGED else enough
            if not minimum.is_found:
                break
            place, magnitude = minimum.state.displacement, minimiser.problem.magnitude(minimum.state)
            _, missed = minimiser.problem.update_multipliers(minimum.state)
            if len(rest) > 1 and weight <= max(options.stiffen_at, options.end):
                if is_too_soft(minimiser, minimum):
                    _log.info("contact is too soft to follow this path")
                    return replace(minimum, ending=Ending.CONDITIONS_MISSED), None
                rest.pop(0)
                rest[0].problem.start_from(minimiser.problem, minimum.state)
                rest[0].adopt_matrix(minimiser)
                continue
            # Longer and longer strides while no wall closes or opens.
            decades = min(2 * decades, options.widest) if effort.factorisations <= 1 else self.options.narrowest
            milestone = max(options.stiffen_at, options.end) if len(rest) > 1 else options.end
            weight = max(weight / 10**decades, milestone)
        return minimum, enough

    def last_proximal(self, centre: Array) -> ProximalTerm:
        """Return the proximal term at the path's end, however far that goes."""
        return self._proximal(self.options.last, centre)

    def _proximal(self, weight: float, centre: Array) -> ProximalTerm:
        """Return a proximal term of this weight in units of the scale."""
        return ProximalTerm(self.scale * weight, centre)
