"""Sums over the terms of a problem."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.term import Configuration, OneSided, Term
from ngcell.problem.unknowns import UnknownMap

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Number = TypeVar("Number", bound=np.generic)


def whole_gradient(term: Term, at: Configuration) -> Array:
    """Return the gradient of a term with that of its constraints, shape (unknowns,)."""
    constraints = term.constraints(at)
    return term.gradient(at) if constraints is None else term.gradient(at) + constraints.gradient


def joined(*parts: NDArray[Number]) -> NDArray[Number]:
    """Return arrays as one; one alone as it is, not as a copy."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def total(parts: Iterable[Array]) -> Array:
    """Return the sum of arrays of one shape."""
    return reduce(add, parts)


def folded(unknowns: UnknownMap, matrices: Iterable[sparse.coo_array | None]) -> sparse.coo_array | None:
    """Return the sum of symmetric matrices in the unknowns that are solved for; None if there are none."""
    found = [matrix for matrix in matrices if matrix is not None]
    return unknowns.fold_curvature(reduce(add, found)) if found else None


def keyed(given: Iterable[OneSided | None], count: int) -> list[OneSided]:
    """Return the constraints that terms give, with keys that differ from term to term; `count` is that of terms."""
    return [
        replace(part, keys=count * part.keys + number) for number, part in enumerate(given) if part is not None
    ]


def sorted_gaps(given: Sequence[tuple[Index, Array] | None]) -> tuple[Index, Array]:
    """Return the keys of the constraints of all terms, as `keyed` makes them, increasing, and their gaps."""
    found = [(len(given) * gaps[0] + number, gaps[1]) for number, gaps in enumerate(given) if gaps is not None]
    if not found:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    keys, gap = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.argsort(keys, kind="stable")
    return keys[order], gap[order]


def together(found: Sequence[OneSided], at: Configuration) -> OneSided:
    """Return constraints with different keys as one."""
    if len(found) == 1:
        return found[0]
    nothing = np.zeros(0)
    lowered = [np.full(len(part.gap), np.nan) if part.lowered is None else part.lowered for part in found]
    rows = [sparse.csr_array((0, len(at.displacement))), *(part.jacobian for part in found)]
    return OneSided(
        np.concatenate([nothing, *(part.gap for part in found)]),
        sparse.vstack(rows, format="csr"),
        np.concatenate([nothing, *(part.penalty for part in found)]),
        np.concatenate([nothing.astype(np.int64), *(part.keys for part in found)]),
        np.concatenate([nothing, *lowered]),
    )


def between_components(row: Index, column: Index, size: int, dimension: int) -> tuple[Index, Index]:
    """Return the entries of the lower triangle between all components of scalar unknowns that entries couple."""
    first = [axis * size for axis in range(dimension)]
    rows = np.concatenate([row + i for i in first for _ in first])
    columns = np.concatenate([column + j for _ in first for j in first])
    lower = rows >= columns
    return rows[lower], columns[lower]
