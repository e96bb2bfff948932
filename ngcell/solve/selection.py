"""Which equilibrium is meant: the release path.

Released cells may float, and their corners may pass each other on either side: equilibria of the energy E are not
unique, not even in energy. The one that is meant is the end of the path of minima of

    E(u) + strength/2 |u - anchor|^2        (mass norm)

from a strong tether to a vanishing one. It is a release by a ramp: the tether gives the walls free little by little.
The path starts at the minimum without contact, which is unique under a strong tether: at the anchor walls touch and
corners meet corners, and it is the forces in the walls, not the round-off of a start, that decide which way they part.
So the equilibrium follows from anchor and energy alone, not from load steps or from where the walk came from. In the
limit, floating cells sit as near to the anchor as contact allows. What the last tether still holds is measured and
reported.

Numbers: the scale of the strength is shear modulus over cell size squared, which makes the walk independent of units.
At ``FIRST`` the tether outweighs everything but the wall's own stiffness, at ``LAST`` it is below every stiffness but
that of floating cells; in between it falls by `RATIO` from step to step.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.minimise import Ending, Minimiser, Minimum, Tether

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

FIRST, LAST, RATIO = 1e3, 1e-7, 10.0
#: Strength, in units of the scale, at which contact stiffens: walls have found their partners there, and floating cells
#: are still held well enough to follow.
STIFFEN_AT = 1e-5
#: Decrement at which a minimisation along the path, and the last one, ends: shares of the tether's energy.
ON_THE_WAY, AT_THE_END = 1e-2, 1e-10
#: Decrement at which a minimisation between updates of contact pressures ends: share of the energy that stands for what
#: conditions are missed by.
UPDATE = 0.1
#: Share of the longest step by which contact conditions may be missed at the end, and the most updates to get there.
CONDITION, MOST_UPDATES = 1e-11, 40
#: Share of what was missed before above which an update was slow.
SLOW = 0.25
#: Share of the energy that what is missed may stand for where updates hardly help: slivers of walls bear nothing.
NOTHING = 1e-11


@dataclass(frozen=True)
class Release:
    """The path's steps.

    Attributes
    ----------
    scale : float
        Shear modulus over squared size of a body [stress / length**2].
    first, last, ratio : float
        Strength at the start and at the end in units of `scale`, and the factor between steps.
    """

    scale: float
    first: float = FIRST
    last: float = LAST
    ratio: float = RATIO

    def strengths(self) -> Iterator[float]:
        """Yield the strengths from first to last [stress / length**2]."""
        steps = max(1, int(np.ceil(np.log(self.first / self.last) / np.log(self.ratio) - 1e-9)))
        for step in range(steps + 1):
            yield self.scale * self.first * (self.last / self.first) ** (step / steps)

    def select(
        self, apart: Minimiser, minimisers: Sequence[Minimiser], start: Array, anchor: Array
    ) -> Minimum:
        """Walk the path and return its end; a minimisation that fails ends the walk.

        Parameters
        ----------
        apart : Minimiser
            Of the problem without contact.
        minimisers : sequence of Minimiser
            Of the released problem, with contact from soft to stiff: the path is walked with the first down to
            `STIFFEN_AT`, where the others take over one after the other, and to its end with the last.
        start, anchor : array of float, shape (unknowns,)
            Where the walk starts and where the tether pulls to [length].
        """
        *strengths, last = self.strengths()
        limit = STIFFEN_AT * self.scale * (1 - 1e-9)
        strong = [strength for strength in strengths if strength >= limit] or strengths[:1]
        # Down to round-off, so that whatever the start, the walk goes on from the same place.
        before, missed = minimisers[0], 0.0
        walk = [(apart, strengths[0], 0.0)]
        walk += [(minimisers[0], strength, ON_THE_WAY) for strength in strong]
        walk += [(minimiser, strong[-1], ON_THE_WAY) for minimiser in minimisers[1:]]
        walk += [(minimisers[-1], strength, ON_THE_WAY) for strength in strengths[len(strong) :]]
        walk += [(minimisers[-1], last, AT_THE_END)]
        place, minimum = start, None
        for minimiser, strength, share in walk:
            tether = Tether(strength, anchor)
            if minimum is not None and minimiser not in (apart, before):
                minimiser.problem.follow(before.problem, minimum.state)
                before = minimiser
            minimum = _minimise(minimiser, place, tether, share, strength / self.scale, UPDATE * missed)
            if minimum.ending is not Ending.CONVERGED:
                return minimum
            place = minimum.state.displacement
            if minimiser is minimisers[-1] and share is not AT_THE_END:
                _, missed = minimiser.problem.improve(minimum.state)
        return _until_conditions_hold(minimiser, minimum, Tether(strength, anchor), strength / self.scale)


def _until_conditions_hold(minimiser: Minimiser, minimum: Minimum, tether: Tether, name: float) -> Minimum:
    """Improve and minimise in turn until there is nothing left to improve."""
    before = float("inf")
    for _ in range(MOST_UPDATES):
        missed, energy = minimiser.problem.improve(minimum.state)
        helpless = missed > before / 2 and energy <= NOTHING * abs(minimum.state.energy)
        if missed <= CONDITION * minimiser.longest_step or helpless:
            return minimum
        _log.info("conditions missed by %.1e", missed)
        if missed > SLOW * before:
            minimiser.problem.hasten()
        before = missed
        minimum = _minimise(minimiser, minimum.state.displacement, tether, AT_THE_END, name, UPDATE * energy)
        if minimum.ending is not Ending.CONVERGED:
            return minimum
    return replace(minimum, ending=Ending.CONDITIONS_MISSED)


def _minimise(
    minimiser: Minimiser, start: Array, tether: Tether, share: float, name: float, enough: float = 0.0
) -> Minimum:
    before = minimiser.effort.copy()
    minimum = minimiser.minimise(start, tether, max(share * minimiser.tether_energy(start, tether), enough))
    spent = minimiser.effort - before
    _log.info(
        "tether %.0e: %s, %d iterations, %d factorisations, %d refused, energy %.8e, decrement %.0e",
        name,
        minimum.ending.value,
        spent.iterations,
        spent.factorisations,
        spent.refusals,
        minimum.state.energy,
        minimum.decrement,
    )
    return minimum
