"""A symmetric matrix that acts on each component of a displacement alike, held once for all of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.problem.unknowns import UnknownMap

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OfComponents:
    """The matrix.

    Attributes
    ----------
    of_one : csr_array, shape (size, size)
        What acts on a component.
    dimension : int
        Number of components.
    unknowns : UnknownMap
        How all unknowns follow from those that are solved for.
    """

    of_one: sparse.csr_array
    dimension: int
    unknowns: UnknownMap

    def __matmul__(self, vector: Array) -> Array:
        """Return the product with a vector, shape (unknowns,)."""
        components = self.unknowns.expand(vector).reshape(self.dimension, -1)
        return self.unknowns.gather(np.concatenate([self.of_one @ component for component in components]))

    def tocsr(self) -> sparse.csr_array:
        """Return all of its entries, shape (unknowns, unknowns)."""
        one, each = self.of_one, range(self.dimension)
        size, count = one.shape[0], one.nnz
        pointer = np.concatenate([[0], *(number * count + one.indptr[1:] for number in each)]).astype(one.indptr.dtype)
        columns = np.concatenate([number * size + one.indices for number in each]).astype(one.indices.dtype)
        values, shape = np.tile(one.data, self.dimension), (self.dimension * size, self.dimension * size)
        return self.unknowns.fold_matrix(sparse.csr_array((values, columns, pointer), shape=shape))
