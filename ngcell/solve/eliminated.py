"""Dense algebra of unknowns that are eliminated: all cliques of the same sizes together, on all threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.cliques import Cliques
from ngcell.threads import at_once, parts_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Eliminated:
    """Cliques of the same sizes, and how they follow their neighbours.

    Attributes
    ----------
    cliques : Cliques
        The cliques.
    among : array of float, shape (cliques, m, m)
        The entries of what is eliminated.
    pulled : array of float, shape (cliques, m, q)
        The solutions with the entries between them and their neighbours.
    """

    cliques: Cliques
    among: Array
    pulled: Array

    @classmethod
    def of(cls, cliques: Cliques, values: Array) -> tuple[Eliminated, Array]:
        """Return cliques of a matrix with these values, and what their elimination takes from the entries of the lower
        triangle of their neighbours, shape (cliques, q (q + 1) / 2)."""
        row, column = np.tril_indices(cliques.around.shape[1])

        def found(some: slice) -> tuple[Array, Array, Array]:
            among, between = values[cliques.among[some]], values[cliques.between[some]]
            pulled = _solved(among, between)
            return among, pulled, (between.transpose(0, 2, 1) @ pulled)[:, row, column]

        among, pulled, change = _joined(cliques, len(values), found)
        return cls(cliques, among, pulled), change

    def taken(self, right: Array) -> Array:
        """Return what their elimination takes from the right-hand side of their neighbours, shape (cliques, q)."""
        inside = self.cliques.inside
        return self._by_parts(right, lambda some: np.einsum("cmq,cm->cq", self.pulled[some], right[inside[some]]))

    def alone(self, right: Array) -> Array:
        """Return their solutions where neighbours are at 0, shape (cliques, m)."""
        inside = self.cliques.inside
        return self._by_parts(right, lambda some: _solved(self.among[some], right[inside[some]][..., None])[..., 0])

    def following(self, whole: Array) -> Array:
        """Return what is to be taken from their solutions where neighbours are not, shape (cliques, m)."""
        around = self.cliques.around
        return self._by_parts(whole, lambda some: np.einsum("cmq,cq->cm", self.pulled[some], whole[around[some]]))

    def _by_parts(self, vector: Array, function: Callable[[slice], Array]) -> Array:
        (found,) = _joined(self.cliques, len(vector), lambda some: (function(some),))
        return found


def _joined(cliques: Cliques, rows: int, function: Callable[[slice], tuple[Array, ...]]) -> tuple[Array, ...]:
    """Return what a function finds for all cliques from what it finds for some of them; arrays begin with cliques."""
    found = at_once(rows, [partial(function, some) for some in parts_of(len(cliques.inside), rows)])
    return found[0] if len(found) == 1 else tuple(map(np.concatenate, zip(*found, strict=True)))


def _solved(matrices: Array, right: Array) -> Array:
    """Return solutions; not a number where there are none: such steps are refused, as all that do not lower the model.

    Products with inverses would lose as many digits as walls that hardly change their volume are stiffer in bulk.
    """
    try:
        return np.asarray(np.linalg.solve(matrices, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full(right.shape, np.nan)
