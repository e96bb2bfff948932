"""Sums over the terms of a problem."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.term import Configuration, Term

Array = NDArray[np.float64]


def whole_gradient(term: Term, at: Configuration) -> Array:
    """Return the gradient of a term with that of its constraints, shape (unknowns,)."""
    constraints = term.constraints(at)
    return term.gradient(at) if constraints is None else term.gradient(at) + constraints.gradient


def total(parts: Iterable[Array]) -> Array:
    """Return the sum of arrays of one shape."""
    return reduce(add, parts)
