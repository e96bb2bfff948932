"""The displacement unknowns, laid out component by component: u_x of all scalar unknowns, then u_y.

A displacement that is affine in the reference coordinates is, in the unknowns, the same affine map of the
coordinates' own unknowns; it is imposed and recognised exactly, bubbles included.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property

import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.geometry.bodies import BodyMesh
from ngcell.mechanics.term import Configuration

Array = NDArray[np.float64]

#: Share of the extent below which a bubble of the coordinates is round-off.
_NO_BUBBLE = 1e-10


class DisplacementSpace:
    """Continuous displacements on separate bodies.

    Parameters
    ----------
    bodies : BodyMesh
        The mesh.
    order : int
        Polynomial order, >= 1.

    Attributes
    ----------
    scalar : ngsolve.H1
        Space of one component, with `size` unknowns.
    vector : ngsolve.VectorH1
        Space of displacements, with `dimension` times `size` unknowns.
    mesh : ngsolve.Mesh
        The mesh of all bodies.
    body_count : int
        Number of bodies.
    """

    def __init__(self, bodies: BodyMesh, order: int) -> None:
        self.bodies, self.mesh, self.body_count = bodies, bodies.mesh, bodies.body_count
        self.order = order
        self.scalar = ngsolve.H1(bodies.mesh, order=order)
        self.vector = ngsolve.VectorH1(bodies.mesh, order=order)
        self.size = self.scalar.ndof
        self.dimension = bodies.dimension
        self._metric: tuple[float, sparse.csr_array] | None = None
        self._curving = None if bodies.rounded is None else bodies.rounded.curving(bodies.mesh, order)
        if self._curving is not None:
            self.mesh.SetDeformation(self._curving)

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return int(self.dimension * self.size)

    @cached_property
    def rest(self) -> Array:
        """Reference coordinates as unknowns, shape (dimension, size) [length]."""
        points = np.array([vertex.point for vertex in self.mesh.vertices]).T
        rows = np.zeros((self.dimension, self.size))
        rows[:, : points.shape[1]] = points
        if self._curving is not None:
            return np.asarray(rows + self._curving.vec.FV().NumPy().reshape(rows.shape))
        if self.mesh.GetCurveOrder() <= 1:  # elements are straight: bubbles are none
            return rows
        field = ngsolve.GridFunction(self.scalar)
        for row, coordinate in zip(rows, (ngsolve.x, ngsolve.y, ngsolve.z), strict=False):
            field.Set(coordinate)
            row[:] = field.vec.FV().NumPy()
        # The projection leaves round-off in the bubbles of straight elements, the more the higher the order.
        rows[np.abs(rows) < _NO_BUBBLE * np.abs(points).max()] = 0
        rows[:, : points.shape[1]] = points
        return rows

    @contextmanager
    def on_chords(self) -> Iterator[None]:
        """Leave elements that follow arcs on the chords of these for a while."""
        if self._curving is None:
            yield
            return
        self.mesh.UnsetDeformation()
        try:
            yield
        finally:
            self.mesh.SetDeformation(self._curving)

    @cached_property
    def one(self) -> Array:
        """The constant 1 as unknowns, shape (size,): bubbles are 0."""
        values = np.zeros(self.size)
        values[: self.mesh.nv] = 1
        return values

    @cached_property
    def body_of_unknown(self) -> NDArray[np.int64]:
        """Body that each scalar unknown belongs to, shape (size,)."""
        body = np.zeros(self.size, dtype=np.int64)
        if self.body_count == 1:
            return body
        for element, number in zip(self.mesh.Elements(ngsolve.VOL), self.bodies.body_of_element, strict=True):
            body[list(self.scalar.GetDofNrs(element))] = number
        return body

    @cached_property
    def scalar_mass(self) -> sparse.csr_array:
        """Mass matrix of one component [length**dimension], shape (size, size)."""
        trial, test = self.scalar.TnT()
        form = ngsolve.BilinearForm(self.scalar)
        form += trial * test * ngsolve.dx
        form.Assemble()
        return csr_matrix(form.mat)

    @cached_property
    def scalar_slopes(self) -> sparse.csr_array:
        """Matrix of the squared gradient of one component [length**(dimension - 2)], shape (size, size)."""
        trial, test = self.scalar.TnT()
        form = ngsolve.BilinearForm(self.scalar)
        form += ngsolve.grad(trial) * ngsolve.grad(test) * ngsolve.dx
        form.Assemble()
        return csr_matrix(form.mat)

    def metric_of_one(self, length: float) -> sparse.csr_array:
        """Return the matrix of one component's square and of that of its gradient times a length [length**dimension].
        """
        if self._metric is None or self._metric[0] != length:
            self._metric = length, self.scalar_mass + length**2 * self.scalar_slopes
        return self._metric[1]

    def region_unknowns(self, region: str | ngsolve.Region) -> NDArray[np.int64]:
        """Return the scalar unknowns on a boundary region, or on those that a regular expression names."""
        marked = self.scalar.GetDofs(self.mesh.Boundaries(region) if isinstance(region, str) else region)
        return np.flatnonzero(np.fromiter(marked, dtype=bool, count=self.size))

    def affine(self, gradient: Array, translation: Array) -> Array:
        """Return ``gradient @ X + translation`` as unknowns, shape (dimension, size)."""
        return np.asarray(gradient @ self.rest + translation[:, None] * self.one)

    def configuration(self, displacement: Array) -> Configuration:
        """Return where bodies are with this displacement, shape (unknowns,) [length]."""
        return Configuration(displacement, self.rest + displacement.reshape(self.dimension, -1))

    def resultants(self, nodal: Array) -> Array:
        """Return the sum of nodal forces, shape (unknowns,), over each body, shape (bodies, dimension)."""
        weighted, count = nodal.reshape(self.dimension, -1) * self.one, self.bodies.body_count
        return np.array([np.bincount(self.body_of_unknown, row, minlength=count) for row in weighted]).T

    def function(self, displacement: Array) -> ngsolve.GridFunction:
        """Return the displacement with these unknowns as an NGSolve function."""
        function = ngsolve.GridFunction(self.vector)
        function.vec.FV().NumPy()[:] = displacement.ravel()
        return function


def csr_matrix(matrix: ngsolve.la.BaseMatrix) -> sparse.csr_array:
    """Return a copy of an NGSolve sparse matrix."""
    values, columns, pointer = matrix.CSR()
    narrow = np.int64 if len(values) > np.iinfo(np.int32).max else np.int32
    parts = np.array(values), np.array(columns, dtype=narrow), np.array(pointer, dtype=narrow)
    return sparse.csr_array(parts, shape=(matrix.height, matrix.width))
