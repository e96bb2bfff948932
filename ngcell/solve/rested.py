"""The end of a path: walls are followed until the proximal force is no more than is allowed, to the last digit.

Under the weight that holds firmly, walls that would slide on stay where they are, and the proximal force tells. They
are followed under smaller weights, down to decrements from which on the firm one pulls by half of what is allowed:
slides of hundreds of iterations, each of which gains less than the accuracy asks for, may gain half of the energy in
all. On the mesh of the path an iteration costs a tenth of one on the finest mesh, and where walls have come to rest
there they hardly slide on finer ones: so they are followed there to less than is allowed, for as long as it pays.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from ngcell.solve.balanced import in_balance
from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.recentred import (
    at_rest,
    decrement_of_pull,
    energy_of_nothing,
    minimised,
    pull_over_felt,
    recentred,
)

_log = logging.getLogger(__name__)


def rested(
    minimiser: Minimiser, minimum: Minimum, scale: float, options: ContinuationOptions, lowest: float = -np.inf
) -> Minimum:
    """Return the equilibrium beside a minimum, to the last digit: conditions of contact hold, and the proximal force is
    no more than a certificate allows.

    As long as it is more, walls are followed on from there, until it is half of that, at first under a tenth of the
    weight under which last digits are found, then under smaller ones. Conditions are met once walls need not be
    followed, and walls go on if they slide as that is done. It ends where the energy falls below `lowest`, and without
    the last digits where no step lowers the energy, as at a kink. Without an accuracy no force is allowed, and the one
    that the path has left stays.
    """
    to_fall, firm = minimum.to_fall, scale * options.resting
    share = options.before_multipliers if minimiser.problem.has_multipliers else options.of_leading
    weight, is_last = options.resting / 10, False
    while minimum.is_found:
        pull = _pull(minimiser, minimum, weight, options)
        if pull <= 1:
            minimum = until_conditions_hold(minimiser, minimum, minimiser.longest_step, options)
            if not (minimum.is_found and options.sufficient):
                break
            pull = _pull(minimiser, minimum, weight, options)
        if pull > 1:
            _log.info("the proximal force is %.2g times what is allowed", pull)
            following = _until_no_pull(minimiser, minimum, firm, replace(options, recentred=weight))
            minimum = recentred(minimiser, minimum.state.displacement, scale * weight, following, lowest)
            if minimum.is_found:
                minimum = at_rest(minimiser, minimum, scale, options.resting, options, share, lowest)
            weight, is_last = max(weight / 10, options.last), False
            continue
        magnitude = minimiser.problem.magnitude(minimum.state)
        enough, nothing = options.refined * magnitude, options.nothing * magnitude
        if is_last or minimum.decrement <= (nothing if minimum.ending is Ending.STALLED else enough):
            break
        is_last, last = True, minimum
        if minimum.proximal.weight < firm:
            minimum = at_rest(minimiser, minimum, scale, options.resting, options, options.refined, lowest)
        else:
            place, held, name = minimum.state.displacement, minimum.proximal, minimum.proximal.weight / scale
            minimum, _ = minimised(minimiser, place, held, 0.0, name, enough, lowest=lowest, is_settled=True)
        if minimum.ending is Ending.NO_DESCENT and last.decrement <= nothing:
            minimum = last
    return replace(in_balance(minimiser, minimum, scale, options), to_fall=to_fall)


def led_to_rest(
    minimiser: Minimiser, minimum: Minimum, scale: float, options: ContinuationOptions, way: int
) -> Minimum:
    """Return the equilibrium beside the end of a path on a mesh that only leads to finer ones, where the proximal force
    is as small as there.

    Walls are followed for as many iterations as the path took, and for as many again while the energy has fallen in
    them by more than a decrement at which minimisations end.
    """
    options = replace(options, allowed=min(options.allowed, options.allowed_to_lead))
    weight, before, times, energy = options.resting / 10, minimiser.effort.iterations, 1, minimum.state.energy
    if not minimum.is_found:
        return minimum
    rest = at_rest(minimiser, minimum, scale, options.resting, options, options.of_leading)
    firm = rest.state.displacement
    while rest.is_found and _pull(minimiser, rest, weight, options) > 1:
        led = minimiser.effort.iterations - before
        if led >= times * way:
            enough = options.update * options.sufficient * minimiser.problem.magnitude(rest.state)
            if times >= options.most_led or energy - rest.state.energy <= enough:
                break
            energy, times = rest.state.energy, led // way + 1
        if minimiser.budget.used > options.led_at_most:
            break
        _log.info("the proximal force is more than leads to finer meshes")
        following = _until_no_pull(minimiser, rest, scale * options.resting, replace(options, recentred=weight))
        place, most = rest.state.displacement, times * way - led
        followed = recentred(minimiser, place, scale * weight, following, most=most)
        is_cut = followed.ending is Ending.TOO_MANY_ITERATIONS
        if is_cut or followed.is_found:
            followed = at_rest(minimiser, followed, scale, options.resting, options, options.of_leading)
        if not followed.is_found:
            return replace(rest, state=minimiser.problem.at(place))  # contact may have adapted
        rest, weight = replace(followed, slid_from=firm), weight if is_cut else max(weight / 10, options.last)
    return rest


def _until_no_pull(
    minimiser: Minimiser, minimum: Minimum, weight: float, options: ContinuationOptions
) -> ContinuationOptions:
    """Return the numbers with which walls are followed until a proximal term of this weight pulls half as much as is
    allowed. With decrements that suffice elsewhere, walls that slide on for hundreds of iterations seem to be at rest.
    """
    felt, sufficient = options.allowed / 2, options.sufficient * minimiser.problem.magnitude(minimum.state)
    update = decrement_of_pull(minimiser, minimum, weight, felt) / sufficient
    return replace(options, felt=felt, update=min(options.update, update))


def _pull(minimiser: Minimiser, minimum: Minimum, weight: float, options: ContinuationOptions) -> float:
    """Return the proximal force over what is allowed.

    It is 0 where walls are not followed on, or under no smaller weight, and where they are hardly strained: nothing
    drives them on.
    """
    if not options.sufficient or weight <= options.last:
        return 0.0
    if minimiser.problem.magnitude(minimum.state) <= energy_of_nothing(minimiser, options):
        return 0.0
    return pull_over_felt(minimiser, minimum, options.allowed)
