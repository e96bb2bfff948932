"""Sums over the terms of a problem."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.term import Configuration, Term
from ngcell.problem.unknowns import UnknownMap

Array = NDArray[np.float64]


def whole_gradient(term: Term, at: Configuration) -> Array:
    """Return the gradient of a term with that of its constraints, shape (unknowns,)."""
    constraints = term.constraints(at)
    return term.gradient(at) if constraints is None else term.gradient(at) + constraints.gradient


def total(parts: Iterable[Array]) -> Array:
    """Return the sum of arrays of one shape."""
    return reduce(add, parts)


def folded(unknowns: UnknownMap, matrices: Iterable[sparse.coo_array | None]) -> sparse.coo_array | None:
    """Return the sum of symmetric matrices in the unknowns that are solved for; None if there are none."""
    found = [matrix for matrix in matrices if matrix is not None]
    return unknowns.fold_curvature(reduce(add, found)) if found else None
