"""What NGSolve knows of boundary facets, read once into arrays."""

from __future__ import annotations

from collections.abc import Sequence

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.surface import Basis

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def sampled(space: ngsolve.H1, elements: Sequence[ngsolve.comp.Ngs_Element], basis: Basis) -> tuple[Index, Array]:
    """Return the unknowns of boundary elements, (facets, nodes), and their shape functions' values at the nodes.

    The values have shape (facets, nodes, nodes), a row for each node.
    """
    size = len(basis.nodes)
    dofs = np.array([space.GetDofNrs(element) for element in elements], dtype=np.int64)
    places, shapes = basis.nodes.reshape(size, -1), dict[tuple[object, ...], Array]()
    nodal = np.array([_shapes(space, element, places, shapes) for element in elements])
    return dofs.reshape(-1, size), nodal.reshape(-1, size, size)


def measured(mesh: ngsolve.Mesh, numbers: Index) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return volumes (in the plane areas), means of vertices, and whether they are simplices, of elements."""
    volume = ngsolve.Integrate(ngsolve.CF(1), mesh, element_wise=True).NumPy()[numbers]
    elements = [mesh[ngsolve.ElementId(ngsolve.VOL, int(number))] for number in numbers]
    centre = [np.mean([mesh[vertex].point for vertex in element.vertices], axis=0) for element in elements]
    is_simplex = np.array([len(element.vertices) == mesh.dim + 1 for element in elements], dtype=bool)
    return volume, np.array(centre).reshape(-1, mesh.dim), is_simplex


def _shapes(
    space: ngsolve.H1, element: ngsolve.comp.Ngs_Element, nodes: Array, known: dict[tuple[object, ...], Array]
) -> Array:
    """Return shape functions' values at nodes; they are the same on elements with vertices in the same order."""
    numbers = [vertex.nr for vertex in element.vertices]
    order = element.type, *sorted(range(len(numbers)), key=numbers.__getitem__)
    if order not in known:
        shape = space.GetFE(ngsolve.ElementId(ngsolve.BND, element.nr)).CalcShape
        known[order] = np.array([np.asarray(shape(*node)).ravel() for node in nodes])
    return known[order]
