"""Where each wall pair opens: the same definition as for the whole tissue, pair by pair."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.results.growth import ONSET

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PairOnsets:
    """Plate displacements at which the mean gap of each pair first reaches `ONSET` wall thicknesses.

    Gaps are taken as straight between the levels, and closed at the start.

    Attributes
    ----------
    onset : array of float, shape (pairs,)
        The onsets so far [length]; NaN where a pair has not opened yet.
    at : float
        Plate displacement of the last level [length].
    gap : array of float, shape (pairs,)
        Mean gaps there [length].
    """

    onset: Array
    at: float
    gap: Array

    @classmethod
    def closed(cls, pairs: int) -> PairOnsets:
        """Return the start, where no pair is open."""
        return cls(np.full(pairs, np.nan), 0.0, np.zeros(pairs))

    def after(self, displacement: float, gap: Array, thickness: float) -> PairOnsets:
        """Return the onsets after one more level, with the wall's thickness [length]."""
        mark, onset = ONSET * thickness, self.onset.copy()
        opened = np.isnan(onset) & (gap >= mark)
        before = np.minimum(self.gap[opened], mark)
        rise = np.maximum(gap[opened] - before, np.finfo(float).tiny)
        onset[opened] = self.at + np.minimum((mark - before) / rise, 1) * (displacement - self.at)
        return replace(self, onset=onset, at=displacement, gap=gap)

    def array(self) -> Array:
        """Return it as one array."""
        return np.array([self.onset, self.gap, np.full_like(self.gap, self.at)])

    @classmethod
    def from_array(cls, rows: Array) -> PairOnsets:
        """Return what `array` was made of."""
        onset, gap, at = rows
        return cls(onset, float(at.max(initial=0.0)), gap)
