"""The step to the minimum of a model, no longer than allowed, and of a model that is not convex, what is sound of it.

No component of a step is longer than `longest_step`: half of the distance in which contact is searched, so that no wall
is passed unseen. A step that is too long is cut; where little would be left of it, the bodies that would move too far
are damped instead, and the others move on.

In a tissue there is nearly always a place where contact forces bend the model downwards: a corner that is about to
pass another. Where that is so in a few of the bodies that contact couples, the inner iteration has come far in all
others before it goes up. That step is taken, and if there is none, those few bodies are damped, by as much as makes the
model convex along the way that went up. Where half of them or more have a part in it, as two bodies always have, the
step counts as a whole: where the model has not fallen along it, the model is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from ngcell.clock import Clock
from ngcell.solve.damping import Damper
from ngcell.solve.effort import Effort
from ngcell.solve.inner import Uphill, minimise_one_sided
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.options import InnerOptions, MinimiserOptions

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NewtonStep:
    """A step.

    Attributes
    ----------
    step : array of float, shape (unknowns,)
        The step [length].
    change, slope : float
        Change of the model along it, and its first-order part [energy].
    share : float
        The share of the whole step that it is.
    not_convex : (array, array) or None
        In a model that is not convex in a few bodies: the way along which it falls, shape (unknowns,) [length], and by
        how much, shape (bodies,) [energy]. The step is what was gained before the iteration went that way.
    """

    step: Array
    change: float
    slope: float
    share: float
    not_convex: tuple[Array, Array] | None

    @property
    def decrement(self) -> float:
        """The Newton decrement of the whole step [energy]: that of a short one is small anywhere."""
        return -self.slope / self.share


@dataclass(frozen=True, eq=False)
class Newton:
    """Finds the steps of a minimisation.

    Parameters
    ----------
    damper : Damper
        What knows the bodies.
    longest_step : float
        Largest change of a displacement unknown in one step [length].
    options : MinimiserOptions
        The method's own numbers.
    clock : Clock
        Where the seconds are added up.
    effort : Effort
        Where the work is added up.
    """

    damper: Damper
    longest_step: float
    options: MinimiserOptions
    clock: Clock
    effort: Effort

    @cached_property
    def _inner(self) -> InnerOptions:
        """Among many bodies what a few of them still have to gain is a small share of what all have gained."""
        inner = self.options.inner
        gain = min(inner.worthwhile_gain, self.options.worthwhile / len(self.damper.none))
        return replace(inner, worthwhile_gain=gain)

    def step(self, model: OneSidedModel, matrix: Matrix, misfit: float = inf) -> NewtonStep:
        """Return the step of a model; the one before was off by a share of its decrease, where that is known."""
        with self.clock.phase("factorisation"):
            found = minimise_one_sided(model, matrix, self._inner.within(misfit))
        self.effort.factorisations += found.factorisations
        step, change, not_convex = found.step, found.change, None
        if found.uphill is not None:
            not_convex = self._not_convex(model, matrix, found.uphill)
            if not_convex and found.uphill.change < 0:
                step, change = found.uphill.step, found.uphill.change
        share = min(self.longest_step / max(float(np.abs(step).max()), float(np.finfo(float).tiny)), 1.0)
        if share < 1:
            step = share * step
            change = model.change(step, matrix.multiply(model.stiffness, step), model.jacobian @ step)
        return NewtonStep(step, change, float(model.full_gradient @ step), share, not_convex)

    def _not_convex(self, model: OneSidedModel, matrix: Matrix, uphill: Uphill) -> tuple[Array, Array] | None:
        """Return the way that went up, and by how much the model falls along it in each body; None if in most."""
        lacking = self.damper.by_body(-uphill.product(model, matrix) * uphill.way)
        return (uphill.way, lacking) if self.damper.is_local(lacking, model.jacobian) else None
