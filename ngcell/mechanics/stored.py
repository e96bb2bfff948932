"""What a configuration stores, body by body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StoredEnergy:
    """What a configuration stores, found when it is asked for.

    Attributes
    ----------
    find : callable
        Returns what each body stores, shape (bodies,), and what belongs to none in particular [energy].
    """

    find: Callable[[], tuple[Array, float]]

    def of(self, group: NDArray[np.bool_]) -> float:
        """Return what the members of a group of bodies store [energy], and what belongs to no body."""
        in_bodies, beside = self._found
        return float(in_bodies[group].sum()) + beside

    @property
    def whole(self) -> float:
        """What all bodies store [energy], and what belongs to none in particular."""
        in_bodies, beside = self._found
        return float(in_bodies.sum()) + beside

    @cached_property
    def _found(self) -> tuple[Array, float]:
        return self.find()
