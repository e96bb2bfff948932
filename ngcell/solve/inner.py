"""The inner problem of a Newton step: a quadratic plus one-sided penalty terms.

Ordinary Newton sees only walls that overlap already; its step then drives many others into each other, and a line
search has to stop it at the first of them. Here the quadratic model has the linearised gap of every near wall, and
its minimum is found by Newton on this piecewise quadratic function with exact line searches: the set of closed
walls changes inside the model, at the price of a factorisation, or of a solution for each penalty term where few of
them change, and without evaluating a single element. Among many bodies each round begins at the minimum in the span of
their low modes (`ngcell.solve.coarse`).

Where contact forces bend a model downwards, a round may end higher than it began. That is told, with what the rounds
before had gained; where it is the first one, the model is minimised anew without modes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.one_sided import Coarse, Matrix, OneSidedModel
from ngcell.solve.options import InnerOptions

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Uphill:
    """A round of the inner iteration that went up: along its way the model is not convex.

    Attributes
    ----------
    way : array of float, shape (unknowns,)
        The way of the round, or a part of it [length].
    closed : array of bool, shape (n,)
        The penalty terms that acted in it.
    step : array of float, shape (unknowns,)
        The step before the round [length].
    change : float
        Change of the model along that step [energy]: 0 where it was the first round.
    """

    way: Array
    closed: NDArray[np.bool_]
    step: Array
    change: float

    def product(self, model: OneSidedModel, matrix: Matrix) -> Array:
        """Return the product of the way and the matrix of the quadratic that went up, shape (unknowns,)."""
        forces = np.where(self.closed, model.penalty * (model.jacobian @ self.way), 0.0)
        return np.where(model.free, matrix.multiply(model.stiffness, self.way) + model.pulled(forces), 0.0)


@dataclass(frozen=True, eq=False)
class InnerStep:
    """What came of the inner problem.

    Attributes
    ----------
    step : array of float, shape (unknowns,)
        A step that nearly minimises the model [length].
    change : float
        Change of the model along it [energy]; not negative where the model falls nowhere.
    factorisations : int
        What it took, with all unknowns and constraints; those to find modes and among them are not counted.
    uphill : Uphill or None
        The last round, if it went up.
    """

    step: Array
    change: float
    factorisations: int
    uphill: Uphill | None = None


def minimise_one_sided(model: OneSidedModel, matrix: Matrix, options: InnerOptions) -> InnerStep:
    """Return a step that nearly minimises the model."""
    reduced = matrix.reduced(model)
    if reduced is None:
        return _minimised(model, None, matrix, options)
    found = _minimised(reduced.model, reduced.coarse, reduced.matrix, options)
    step, uphill = reduced.whole(found.step), found.uphill
    if uphill is not None:
        before, change = reduced.whole(uphill.step), uphill.change
        change = reduced.change + change if change < 0 else 0.0
        uphill = replace(uphill, way=step - before, step=before, change=change)
    return replace(found, step=step, change=reduced.change + found.change, uphill=uphill)


def _minimised(model: OneSidedModel, coarse: Coarse | None, matrix: Matrix, options: InnerOptions) -> InnerStep:
    descent, change, uphill = Descent(model, matrix, options.lost), 0.0, None
    for round_number in range(options.most_rounds):
        is_led = round_number == 0 and coarse is not None
        if coarse is not None:
            way, gained = _among_modes(coarse, descent, options)
            descent.move(way)
            change += gained
            coarse = coarse if gained < options.coarse.worthwhile_gain * change else None
        last, closed = descent.step, descent.gap < 0
        settled = descent.advance(model.gap)
        before, change = change, model.change(descent.step, descent.curved, descent.moved)
        if not change <= before + options.round_off * abs(before):
            if is_led:  # What modes gain alone is no step: iterations of such steps creep.
                anew = _minimised(model, None, matrix, options)
                return replace(anew, factorisations=anew.factorisations + descent.factorisations)
            uphill = Uphill(descent.step - last, closed, last, before)
        if settled or not change < 0 or before - change < -options.worthwhile_gain * change:
            break
    return InnerStep(descent.step, change, descent.factorisations, uphill)


def _among_modes(coarse: Coarse, descent: Descent, options: InnerOptions) -> tuple[Array, float]:
    """Return the way that lowers the model among the modes of bodies, shape (unknowns,), and its change."""
    model, limits = coarse.after(descent.gradient, descent.gap), options.coarse
    among = replace(options, most_rounds=limits.most_rounds, worthwhile_gain=limits.worthwhile_gain)
    found = _minimised(model, None, coarse.matrix, among)
    step, change = (found.step, found.change) if found.uphill is None else (found.uphill.step, found.uphill.change)
    return np.asarray(coarse.basis @ step), change


class Descent:
    """Newton steps with exact line searches, from a step of nothing, on a model whose gaps may change on the way.

    Parameters
    ----------
    model : OneSidedModel
        The model.
    matrix : Matrix
        What solves for it.
    lost : float
        Factor by which corrections of an inverse may enlarge round-off.

    Attributes
    ----------
    step, curved : array of float, shape (unknowns,)
        The step, and its product with the matrix of the model.
    moved, gap : array of float, shape (n,)
        What the step adds to the gaps, and the gaps after it.
    """

    def __init__(self, model: OneSidedModel, matrix: Matrix, lost: float) -> None:
        self._model, self._matrix, self._quadratics = model, matrix, _Quadratics(model, matrix, lost)
        self.step, self.curved = np.zeros_like(model.gradient), np.zeros_like(model.gradient)
        self.gap, self.moved = model.gap, np.zeros_like(model.gap)

    @property
    def factorisations(self) -> int:
        """Number of factorisations so far."""
        return self._quadratics.factorisations

    @property
    def gradient(self) -> Array:
        """The gradient of the quadratic without penalty terms after the step."""
        return self._model.gradient + self.curved

    def move(self, way: Array) -> None:
        """Go along a way."""
        self.step = self.step + way
        self.curved = self.curved + self._matrix.multiply(self._model.stiffness, way)
        self.moved = self.moved + self._model.jacobian @ way
        self.gap = self._model.gap + self.moved

    def advance(self, gap: Array) -> bool:
        """Go towards the minimum with these gaps at a step of nothing, and tell whether the closed ones stay closed."""
        model = self._model
        before = gap + self.moved
        was_closed = np.flatnonzero(before < 0)
        towards = self._quadratics.minimum(was_closed, gap) - self.step
        way, curves = model.jacobian @ towards, self._matrix.multiply(model.stiffness, towards)
        constant, linear = float(model.gradient @ towards + self.step @ curves), float(towards @ curves)
        fraction = _root_of_slope(constant, linear, model.penalty, before, way)
        self.step, self.curved = self.step + fraction * towards, self.curved + fraction * curves
        self.moved = self.moved + fraction * way
        self.gap = gap + self.moved
        return np.array_equal(was_closed, np.flatnonzero(self.gap < 0))


class _Quadratics:
    """The quadratics in which some penalty terms act, and their minima.

    One of them is factorised. Where few penalty terms have closed or opened since, what they add is a matrix of low
    rank, and its inverse follows from that of the factorised one (Sherman-Morrison-Woodbury; Hager, SIAM Rev. 31, 1989,
    doi:10.1137/1031049).
    """

    def __init__(self, model: OneSidedModel, matrix: Matrix, lost: float) -> None:
        self._model, self._matrix, self._lost = model, matrix, lost
        self._acting: Index | None = None
        self._pulled: dict[int, Array] = {}
        self.factorisations = 0

    def minimum(self, closed: Index, gap: Array) -> Array:
        """Return the minimum of the quadratic in which just these penalty terms act, with these gaps."""
        model = self._model
        pull = np.zeros_like(gap)
        pull[closed] = model.penalty[closed] * gap[closed]
        right = -(model.gradient + model.pulled(pull))
        if self._acting is not None:
            changed = np.setxor1d(closed, self._acting, assume_unique=True)
            if len(changed) <= self._matrix.few:
                minimum = self._corrected(self._matrix.solve(right), changed, np.isin(changed, closed))
                if minimum is not None:
                    return minimum
        self._factorise(closed)
        return self._matrix.solve(right)

    def _factorise(self, closed: Index) -> None:
        model = self._model
        self._matrix.factorise(model.stiffness, model.jacobian[closed], model.penalty[closed])
        self._acting, self._pulled = closed, {}
        self.factorisations += 1

    def _corrected(self, solution: Array, changed: Index, closes: NDArray[np.bool_]) -> Array | None:
        """Return a solution with these penalty terms closed, or else opened; None where digits are lost.

        That is where a penalty term opens that alone held a body: what still holds it is the difference of large
        numbers.
        """
        if not len(changed):
            return solution
        jacobian, root = self._model.jacobian[changed], np.sqrt(self._model.penalty[changed])
        pulled = root * np.stack([self._pulled_by(number) for number in changed.tolist()], axis=1)
        gap = root * (jacobian @ solution)
        try:
            force = np.linalg.solve(root[:, None] * (jacobian @ pulled) + np.diag(np.where(closes, 1.0, -1.0)), gap)
        except np.linalg.LinAlgError:
            return None
        return solution - pulled @ force if np.abs(force).max() <= self._lost * np.abs(gap).max() else None

    def _pulled_by(self, number: int) -> Array:
        """Return what a unit force of a penalty term does to the factorised quadratic, shape (unknowns,)."""
        if number not in self._pulled:
            jacobian, force = self._model.jacobian, np.zeros_like(self._model.gradient)
            entries = slice(*jacobian.indptr[number : number + 2])
            np.add.at(force, jacobian.indices[entries], jacobian.data[entries])  # an unknown may occur twice
            self._pulled[number] = self._matrix.solve(force)
        return self._pulled[number]


def _root_of_slope(constant: float, linear: float, penalty: Array, gap: Array, moved: Array) -> float:
    """Return where ``constant + s linear + sum penalty term min(0, gap + s moved) moved`` vanishes, at most 1.

    The slope is piecewise linear in s: it breaks where a penalty term closes or opens.
    """
    closed, offset, bend = (gap < 0) | ((gap == 0) & (moved < 0)), penalty * gap * moved, penalty * moved**2
    constant += float(offset[closed].sum())
    linear += float(bend[closed].sum())
    if constant >= 0:
        return 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        at = -gap / moved
    change = np.flatnonzero((at > 0) & (at < 1))
    change = change[np.argsort(at[change])]
    turn = np.where(moved[change] < 0, 1.0, -1.0)
    constants = constant + np.concatenate([[0], np.cumsum(turn * offset[change])])
    linears = linear + np.concatenate([[0], np.cumsum(turn * bend[change])])
    ends = np.concatenate([at[change], [1.0]])
    positive = np.flatnonzero(constants + ends * linears > 0)
    if not len(positive):
        return 1.0
    piece = positive[0]
    return float(min(-constants[piece] / linears[piece], 1.0))
