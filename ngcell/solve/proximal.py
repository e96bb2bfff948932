"""The proximal term: what holds floating bodies while a minimum is looked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ProximalTerm:
    """The energy ``weight/2 |u - centre|^2`` in the norm of a metric (Rockafellar 1976, doi:10.1137/0314056).

    Attributes
    ----------
    weight : float
        Stiffness per reference volume [stress / length**2], >= 0.
    centre : array of float, shape (unknowns,)
        Where it vanishes [length].
    """

    weight: float
    centre: Array

    def value(self, displacement: Array, metric: sparse.csr_array) -> float:
        """Return the energy."""
        away = displacement - self.centre
        return 0.5 * self.weight * float(away @ (metric @ away))

    def gradient(self, displacement: Array, metric: sparse.csr_array) -> Array:
        """Return its gradient, shape (unknowns,); its tangent is `weight` times the metric."""
        return np.asarray(self.weight * (metric @ (displacement - self.centre)))
