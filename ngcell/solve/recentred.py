"""The proximal point method: the end of a path, where the proximal term holds bodies where they have come free.

Each minimum is the centre of the next proximal term (Rockafellar 1976, doi:10.1137/0314056), so that bodies that
nothing holds stay, and no proximal force is left in the end. Where they creep on, the next centre is ahead of the
minimum, by what the last two ways foresee (Anderson 1965, doi:10.1145/321296.321305). `recentred` goes on until the
energy hardly falls any more; `at_rest` finds the digits after that, down to round-off where a state is reported. They
are found under a weight that holds firmly: under a small one they take several times the iterations, since cells slide
on along others for falls of the energy that suffice no more to be of interest. What the term then pulls is weighed
where a state is reported.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.effort import Effort
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.proximal import ProximalTerm

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


def recentred(
    minimiser: Minimiser, start: Array, weight: float, options: ContinuationOptions, lowest: float = -np.inf,
    *, is_settled: bool = False, most: int = 0,
) -> Minimum:  # fmt: skip
    """Return a state near a place from which the energy hardly falls any more.

    It ends where all falls of the energy that are still to come, as many as go on like the last two, are no more than
    what suffices, and the proximal force is not felt; or where bodies are hardly strained at all. What may still fall
    is told. Where falls are slow, the weight is lowered. An energy below `lowest` ends it, too, as no equilibrium; and
    so do overlaps that stiffer and stiffer penalty terms do not undo, and so many iterations, if `most` is not 0.
    """
    before_it = minimiser.effort.iterations
    proximal, fallen, scale = ProximalTerm(weight, start), float("inf"), weight / options.recentred
    ways, overlaps, place = _Ways(minimiser), _Overlaps(options), start
    for _ in range(options.most_recentred):
        state, name = minimiser.problem.at(place), proximal.weight / scale  # contact may have adapted
        energy = state.energy
        sufficient = max(options.sufficient * minimiser.problem.magnitude(state), energy_of_nothing(minimiser, options))
        enough = options.update * sufficient
        left = max(most - (minimiser.effort.iterations - before_it), 1) if most else None
        minimum, _ = minimised(minimiser, place, proximal, 0.0, name, enough, left, lowest, is_settled=is_settled)
        if not minimum.is_found:
            return minimum
        before, fallen = fallen, energy - minimum.state.energy
        ratio = fallen / before if before > 0 else 0.0
        to_fall = fallen / (1 - min(max(ratio, 0.0), options.idle))
        has_multipliers = minimiser.problem.has_multipliers
        is_end = to_fall <= sufficient and pull_over_felt(minimiser, minimum, options.felt) <= 1
        if is_end and not has_multipliers:
            break
        missed, _ = minimiser.problem.update_multipliers(minimum.state)
        if not has_multipliers and overlaps.stay(missed, minimum.state.energy):
            return replace(minimum, ending=Ending.CONDITIONS_MISSED)
        is_slow = ratio > (options.idle_at_last if to_fall <= sufficient else options.idle)
        weight = max(proximal.weight / 10, scale * options.last) if is_slow else proximal.weight
        place = minimum.state.displacement
        if weight != proximal.weight or fallen < 0:
            ways = _Ways(minimiser)
        proximal = ProximalTerm(weight, ways.next_centre(proximal.centre, place, options.idle))
        if is_end:
            break
    return replace(minimum, to_fall=to_fall)


def at_rest(
    minimiser: Minimiser,
    minimum: Minimum,
    scale: float,
    weight: float,
    options: ContinuationOptions,
    share: float,
    lowest: float = -np.inf,
) -> Minimum:
    """Return the minimum beside a state, down to a decrement that is a share of the energy.

    The proximal term holds bodies where they are, by `weight` times `scale`.
    """
    proximal = ProximalTerm(scale * weight, minimum.state.displacement)
    enough = share * max(minimiser.problem.magnitude(minimum.state), energy_of_nothing(minimiser, options))
    settled = not options.only_leads  # what only leads may still be on its way between branches
    found, _ = minimised(minimiser, proximal.centre, proximal, 0.0, weight, enough, lowest=lowest, is_settled=settled)
    return replace(found, to_fall=minimum.to_fall)


def minimised(
    minimiser: Minimiser,
    start: Array,
    proximal: ProximalTerm,
    share: float,
    name: float,
    enough: float = 0.0,
    most: int | None = None,
    lowest: float = -np.inf,
    *,
    is_settled: bool = False,
) -> tuple[Minimum, Effort]:
    """Return a minimum under a proximal term, and what it took.

    It ends at a decrement of so much, or of a share of the proximal energy at the start. `name` is the weight that is
    told.
    """
    before = minimiser.effort.copy()
    tolerance = max(share * minimiser.proximal_energy(start, proximal), enough)
    minimum = minimiser.minimise(start, proximal, tolerance, most, lowest, is_settled=is_settled)
    spent = minimiser.effort - before
    _log.info(
        "proximal weight %.0e: %s, %d iterations, %d factorisations, %d refused, energy %.8e, decrement %.0e",
        name,
        minimum.ending.value,
        spent.iterations,
        spent.factorisations,
        spent.refusals,
        minimum.state.energy,
        minimum.decrement,
    )
    return minimum, spent


def energy_of_nothing(minimiser: Minimiser, options: ContinuationOptions) -> float:
    """Return the energy that is told from nothing no more."""
    return options.hardly_strained**2 * minimiser.energy_scale


@dataclass
class _Overlaps:
    """Overlaps of penalty terms that were too soft: ten times as stiff, they leave a tenth of them where walls press
    each other. Where walls have come to sides of each other from which they do not find back, they leave more, and
    their energy grows with their stiffness.

    Attributes
    ----------
    options : ContinuationOptions
        What counts as undone.
    """

    options: ContinuationOptions
    _deepest: float = float("inf")
    _energy: float = float("inf")
    _in_vain: int = 0

    def stay(self, deepest: float, energy: float) -> bool:
        """Return whether overlaps stay however stiff penalty terms become; `deepest` [length] is 0 if none was made
        stiffer. Nothing is told of them while the energy falls: walls slide on to other places."""
        stays = deepest > self.options.undone * self._deepest and energy >= self._energy
        self._in_vain = self._in_vain + 1 if stays else 0
        self._deepest, self._energy = deepest or float("inf"), energy
        return self._in_vain == self.options.most_in_vain


@dataclass
class _Ways:
    """The last ways from a centre to the minimum near it, under one weight.

    Attributes
    ----------
    minimiser : Minimiser
        What goes them.
    """

    minimiser: Minimiser
    _last: tuple[Array, Array] | None = None

    def next_centre(self, centre: Array, place: Array, idle: float) -> Array:
        """Return the next centre after the minimum `place`: where ways that shrink by a steady ratio lead to.

        That is one step of Anderson's method of depth 1. The ratio is at most `idle`, and the centre at most a longest
        step ahead.
        """
        way, before = place - centre, self._last
        self._last = way, place
        if before is None:
            return place
        shrunk, moved = before[0] - way, place - before[1]
        weighed, farthest = self.minimiser.problem.metric @ shrunk, float(np.abs(moved).max())
        if not farthest or not float(shrunk @ weighed):
            return place
        share = max(float(way @ weighed) / float(shrunk @ weighed), 0.0)
        return np.asarray(place + min(share, idle / (1 - idle), self.minimiser.longest_step / farthest) * moved)


def pull_over_felt(minimiser: Minimiser, minimum: Minimum, share: float) -> float:
    """Return the pull of the proximal term on a body, or on all together, over what is felt: a share of the largest
    force on a body, or on all together of the force that goes through the supports, if that is more; or, if that is
    most, its nodal forces over that share of those within bodies."""
    problem, state = minimiser.problem, minimum.state
    gradient, constraints = problem.gradient(state), problem.gradient_of_constraints(state)
    nodal = minimum.proximal.gradient(state.displacement, problem.metric)
    support = _at_supports(minimiser, minimum, gradient)
    pull, within = problem.resultants(nodal), float(np.linalg.norm(gradient - constraints))
    on_body = max(_largest(problem.resultants(constraints)), _largest(support))
    on_all = max(on_body, force_through(support))
    if not share * on_body > 0:
        return 0.0
    of_nodes = float(np.linalg.norm(nodal)) / max(within, on_body)
    return max(_largest(pull) / on_body, float(np.linalg.norm(pull.sum(axis=0))) / on_all, of_nodes) / share


def decrement_of_pull(minimiser: Minimiser, minimum: Minimum, weight: float, share: float) -> float:
    """Return the decrement from which on a proximal term of this weight pulls no body by more than a share of the
    largest force on one.

    A way d to the minimum of energy and proximal term, ``weight/2 |d|^2``, costs no more than the energy gains. What
    pulls a body of mass m is ``weight m`` times its mean way, and at most ``weight sqrt(m) |d|``.
    """
    problem, state = minimiser.problem, minimum.state
    contact = problem.resultants(problem.gradient_of_constraints(state))
    force = max(_largest(contact), _largest(_at_supports(minimiser, minimum, problem.gradient(state))))
    mass = float(problem.resultants(problem.metric @ np.ones_like(state.displacement))[:, 0].max())
    return (share * force) ** 2 / (2 * weight * mass)


def is_too_soft(minimiser: Minimiser, minimum: Minimum) -> bool:
    """Return whether walls overlap by more than a longest step, half of the thinnest wall, at a minimum.

    A point that is past the middle of a wall may be nearer to its far side, and stiffer contact does not bring it back.
    """
    _, gaps = minimiser.problem.gaps(minimum.state)
    return float(gaps.min(initial=0.0)) < -minimiser.longest_step


def force_through(forces: Array) -> float:
    """Return the force that goes through bodies from some supports to others, as from one plate to the other.

    It is the sum of the forces on bodies, shape (bodies, dimension), that point one way in each direction. Forces on
    one plate that point against each other count in it.
    """
    return float(np.linalg.norm(np.maximum(forces, 0.0).sum(axis=0)))


def _at_supports(minimiser: Minimiser, minimum: Minimum, gradient: Array) -> Array:
    """Return the forces of supports on bodies, shape (bodies, dimension)."""
    problem = minimiser.problem
    nodal = minimum.proximal.gradient(minimum.state.displacement, problem.metric)
    return problem.resultants(np.where(problem.free, 0.0, gradient + nodal))


def _largest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())
