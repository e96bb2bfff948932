"""Onset of gap growth of each wall pair, by the definition of `ngcell.results.growth`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.results.growth import ONSET

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PairOnsets:
    """Plate displacements at which the mean gap of each pair first reaches `ONSET` wall thicknesses.

    Gaps are interpolated linearly between the levels. A pair that is open where its curve starts has its onset there.

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
    def starting(cls, displacement: float, gap: Array, thickness: float | Array) -> PairOnsets:
        """Return the onsets where the curves start, with these mean gaps and wall thicknesses [length], both of shape
        (pairs,)."""
        return cls(np.where(gap >= ONSET * thickness, displacement, np.nan), displacement, gap)

    def after(self, displacement: float, gap: Array, thickness: float | Array) -> PairOnsets:
        """Return the onsets after one more level with these mean gaps and wall thicknesses [length], shape (pairs,).
        """
        mark, onset = np.broadcast_to(ONSET * np.asarray(thickness), gap.shape), self.onset.copy()
        opened = np.isnan(onset) & (gap >= mark)
        mark = mark[opened]
        before = np.minimum(self.gap[opened], mark)
        rise = np.maximum(gap[opened] - before, np.finfo(float).tiny)
        onset[opened] = self.at + np.minimum((mark - before) / rise, 1) * (displacement - self.at)
        return replace(self, onset=onset, at=displacement, gap=gap)

    def array(self) -> Array:
        """Return onsets, gaps and the displacement as one array, shape (3, pairs)."""
        return np.array([self.onset, self.gap, np.full_like(self.gap, self.at)])

    @classmethod
    def from_array(cls, rows: Array) -> PairOnsets:
        """Return the onsets that `array` was made from."""
        onset, gap, at = rows
        return cls(onset, float(at.max(initial=0.0)), gap)
