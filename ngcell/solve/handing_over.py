"""From a penalty to multipliers: the equilibrium by the contact that is meant, beside one by a penalty that led to it.

Multipliers take over its forces. Walls are still where the penalty has let them overlap: a second-order model undoes
most of that before anything is minimised (`ngcell.solve.foreseen`). Without overlaps walls slide on, far for little
energy; a firm proximal term holds them, and where they slide far, the penalty leads on from there.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np

from ngcell.solve.continuation import Continuation
from ngcell.solve.foreseen import with_first_multipliers
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import SolverOptions
from ngcell.solve.problem import Problem
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.recentred import at_rest, recentred
from ngcell.solve.refined import settled
from ngcell.solve.rested import rested
from ngcell.solve.stability import stable_minimum

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class HandingOver:
    """What hands over from one contact to the other.

    Attributes
    ----------
    leads, last : Minimiser
        With the penalty that leads, and with the contact that is meant.
    path : Continuation
        The path on which equilibria are selected.
    options : SolverOptions
        The solver's own numbers; those of the path are the path's.
    """

    leads: Minimiser
    last: Minimiser
    path: Continuation
    options: SolverOptions

    def equilibrium(
        self, led: Minimum, before: Problem, *, may_slide: bool = True, leads_below: float = -np.inf
    ) -> Minimum:
        """Return the equilibrium by the contact that is meant, beside one of the problem `before`, which leads to it.

        Where walls slide away from there, `before` leads on from where they have come to, if they may, and else a
        coarser mesh. Where it comes back to where it was, they have not slid: what falls is the difference of the
        methods, as on coarse meshes.
        Where the energy falls below `leads_below`, it only leads to a finer mesh, and last digits are not looked for.
        """
        leads, options, led_before = self.leads, self.path.options, np.inf
        slid = options.slid * (1.0 if may_slide else 0.5)
        for _ in range(options.most_leads):
            sufficient = options.sufficient * leads.problem.magnitude(led.state)
            is_back = led.state.energy > led_before - sufficient
            lowest = -np.inf if is_back else led.state.energy - (slid * sufficient or np.inf)
            led_before = led.state.energy
            minimum = self._taken_over(led, before, lowest)
            if minimum.is_found and minimum.state.energy < leads_below:
                break
            if minimum.is_found and minimum.proximal.weight:
                minimum = self._stable(minimum, lowest)
            if minimum.is_found and minimum.proximal.weight:
                minimum = self._rested(minimum, lowest)
            if not may_slide or minimum.ending not in (Ending.SLID, Ending.NO_DESCENT):
                break
            _log.info(minimum.ending.value)
            start, length = minimum.state.displacement, self.last.longest_step
            led = settled(
                (leads,), start, length=length, options=self.options, path=self.path, share=options.of_leading
            )
            if not led.is_found:
                return led
        return minimum

    def _taken_over(self, led: Minimum, before: Problem, lowest: float) -> Minimum:
        """Return a state near a minimum of the problem `before`, by the contact that is meant, from which the energy
        hardly falls any more."""
        last = self.last
        last.adopt_matrix(self.leads)
        last.forget_matrix()
        last.problem.start_from(before, led.state)
        start = led.state.displacement
        if not led.proximal.weight:
            return settled((last,), start, length=last.longest_step, options=self.options)
        handing = self.path.options.handing_over
        weight = self.path.scale * handing.recentred
        start = with_first_multipliers(last, start, ProximalTerm(weight, start), handing.foreseen)
        return recentred(last, start, weight, handing, lowest)

    def _stable(self, minimum: Minimum, lowest: float) -> Minimum:
        """Return a state from which the energy hardly falls any more, which is no saddle: one that is left before its
        last digits are found is left at half the price."""
        handing = self.path.options.handing_over

        def until_it_hardly_falls(below: Minimum) -> Minimum:
            place = below.state.displacement
            return recentred(self.last, place, self.path.scale * handing.recentred, handing, lowest)

        scale, length = self.path.scale, self.last.longest_step
        options = self.options.stability
        return stable_minimum(self.last, minimum, until_it_hardly_falls, options, scale=scale, length=length)

    def _rested(self, minimum: Minimum, lowest: float) -> Minimum:
        """Return the equilibrium beside a state to which multipliers have taken over, to the last digit."""
        last, handing = self.last, self.path.options.handing_over
        share = handing.before_multipliers
        minimum = at_rest(last, minimum, self.path.scale, handing.resting, handing, share, lowest)
        return rested(last, minimum, self.path.scale, self.path.options, lowest) if minimum.is_found else minimum
