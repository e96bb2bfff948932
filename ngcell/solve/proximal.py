"""The proximal term: what holds floating bodies while a minimum is looked for."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.problem import SymmetricOperator

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
    _last: list[tuple[Array, SymmetricOperator, Array]] = field(init=False, default_factory=list, repr=False)

    def value(self, displacement: Array, metric: SymmetricOperator) -> float:
        """Return the energy."""
        return 0.5 * self.weight * float((displacement - self.centre) @ self._pull(displacement, metric))

    def gradient(self, displacement: Array, metric: SymmetricOperator) -> Array:
        """Return its gradient, shape (unknowns,); its tangent is `weight` times the metric."""
        return self.weight * self._pull(displacement, metric)

    def _pull(self, displacement: Array, metric: SymmetricOperator) -> Array:
        """Return the gradient of half of the squared distance; energies and gradients are asked for in turns."""
        if not self._last or self._last[0][0] is not displacement or self._last[0][1] is not metric:
            self._last[:] = [(displacement, metric, np.asarray(metric @ (displacement - self.centre)))]
        return self._last[0][2]
