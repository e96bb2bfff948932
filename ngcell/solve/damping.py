"""Damping of Newton steps, body by body: where the second-order model of the energy fails, and nowhere else.

In a tissue walls slide past corners here and there at once. Damped as one, all bodies would wait for the one whose step
was foreseen worst; the energy is a sum over bodies and pairs of them, and so is what the model lacks. Between two
places it is, body by body, half of the forces that the model did not foresee times the way (the trapezoidal rule).
Bodies that are tied to each other are one: what folds in one of them is moved by all.
Damping weights are multiples of the metric of displacements, ``sqrt(weight_i weight_j) M_ij``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.options import MinimiserOptions
from ngcell.solve.problem import SymmetricOperator

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of what the model lacks altogether that the bodies have among them of which each gets more damping.
_MOST_OF_IT = 0.99
#: Damping beyond which a body does not move at all, and products would overflow.
_LARGEST = 1e150


@dataclass(frozen=True, eq=False)
class Damper:
    """How damping changes.

    Parameters
    ----------
    metric : SymmetricOperator, shape (unknowns, unknowns)
        What damping is a multiple of.
    part : array of int, shape (unknowns,)
        Body of each unknown; bodies that are tied to each other are one.
    options : MinimiserOptions
        The numbers of the method.
    """

    metric: SymmetricOperator
    part: Index
    options: MinimiserOptions

    @cached_property
    def none(self) -> Array:
        """No damping, shape (bodies,)."""
        return np.zeros(int(self.part.max(initial=0)) + 1)

    def by_body(self, values: Array) -> Array:
        """Return the sums of values of unknowns over each body, shape (bodies,)."""
        return np.bincount(self.part, weights=values, minlength=len(self.none)).astype(float)

    def raised(self, damping: Array, step: Array, slope: float, lacking: Array) -> Array:
        """Return the damping after a step that was refused.

        Parameters
        ----------
        damping : array of float, shape (bodies,)
            That of the step.
        step : array of float, shape (unknowns,)
            The step [length].
        slope : float
            Decrease of the energy along the step, to first order [energy].
        lacking : array of float, shape (bodies,)
            What the model lacks in each body [energy]; only ratios count.
        """
        at_fault = self._at_fault(lacking)
        # As much for each of them: what presses a body at rest is at fault, too, and must not be frozen in its place.
        return self._at_least(self.options.felt * abs(slope), damping, step, at_fault)

    def shortened(self, damping: Array, step: Array, slope: float) -> Array:
        """Return the damping after a step of which little is left, since some bodies would go too far.

        It is raised in those that the cut step still moves by more than the share that is left, which would go too far
        themselves, so that they go as far as the cut step does. The model hardly holds them, as where the pressure
        in a filling is far from balanced. Parameters as for `raised`.
        """
        longest = np.zeros_like(damping)
        np.maximum.at(longest, self.part, np.abs(step))
        far = longest > self.options.short * longest.max()
        return self._at_least(abs(slope), damping, step, far)

    def straightened(self, damping: Array, way: Array, lacking: Array) -> Array:
        """Return the damping with which a model falls no more along a way on which it is not convex.

        Parameters
        ----------
        damping : array of float, shape (bodies,)
            That of the model.
        way : array of float, shape (unknowns,)
            The way [length].
        lacking : array of float, shape (bodies,)
            Minus the product of the way with the model's matrix and itself, body by body [energy].
        """
        return self._at_least(float(np.maximum(lacking, 0.0).sum()), damping, way, self._at_fault(lacking))

    def is_local(self, lacking: Array, couplings: sparse.csr_array) -> bool:
        """Return whether a model lacks what it lacks in a few of the bodies that contact couples, and not altogether.

        Bodies that contact does not couple with those at fault, directly or by others, do not count.

        Parameters
        ----------
        lacking : array of float, shape (bodies,)
            What the model lacks in each body [energy].
        couplings : csr_array, shape (n, unknowns)
            The unknowns that each penalty term couples.
        """
        if not (lacking > 0).any():
            return False
        rows = np.repeat(np.arange(couplings.shape[0]), np.diff(couplings.indptr))
        entries = np.ones(len(rows)), (rows, self.part[couplings.indices])
        bodies = sparse.csr_array(entries, shape=(couplings.shape[0], len(lacking)))
        coupled, at_fault = bodies.T @ bodies, self._at_fault(lacking)
        before, together = 0, at_fault
        while before < together.sum():
            before, together = int(together.sum()), together | (coupled @ together > 0)
        return int(at_fault.sum()) < self.options.local * before

    def relaxed(self, damping: Array, step: Array, slope: float, lacking: Array, quality: float) -> Array:
        """Return the damping after an accepted step; parameters as for `raised`."""
        unfelt = self.options.unfelt * abs(slope) / np.maximum(self._way(step), np.finfo(float).tiny)
        lowered = np.where(self.options.lower_by * damping > unfelt, self.options.lower_by * damping, 0.0)
        if quality >= self.options.fair:
            return lowered
        nudged = np.maximum(self.options.nudge_by * damping, unfelt)
        return np.where(self._at_fault(lacking), nudged, lowered)

    def _at_least(self, energy: float, damping: Array, step: Array, where: NDArray[np.bool_]) -> Array:
        """Return the damping raised in some bodies, so that it takes at least this energy along a step of them."""
        needed = energy / max(float(self._way(step)[where].sum()), float(np.finfo(float).tiny))
        raised = np.maximum(self.options.raise_by * damping, needed)
        return np.where(where, np.minimum(raised, _LARGEST), damping)

    def _way(self, step: Array) -> Array:
        """Return the squared way of each body in the metric, shape (bodies,)."""
        return self.by_body(step * (self.metric @ step))

    def _at_fault(self, lacking: Array) -> NDArray[np.bool_]:
        """Return the bodies that have most of what the model lacks, all where nothing is known, shape (bodies,)."""
        positive = np.maximum(lacking, 0.0)
        if not positive.any():
            return np.ones(len(lacking), dtype=bool)
        order = np.argsort(-positive, kind="stable")
        before = np.cumsum(positive[order]) - positive[order]
        at_fault = np.zeros(len(lacking), dtype=bool)
        at_fault[order] = before < _MOST_OF_IT * positive.sum()
        return at_fault
