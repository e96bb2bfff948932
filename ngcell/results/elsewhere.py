"""Where a higher order has changed the state: in the elements that a grade splits towards corners, or elsewhere.

Energies err by moduli times the squares of strains. By the squares of what strains have changed by, in each element,
what an order has changed the potential by is a sum over the elements. That of the elements which a grade does not split
along walls tells an error that the grade leaves.
"""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]


def share_elsewhere(
    space: DisplacementSpace, moduli: Array, before: Array, after: Array, graded: DisplacementSpace
) -> float:
    """Return the share of a change of the potential that a grade does not lower, in [0, 1].

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns of the displacements before and after the change.
    moduli : array of float, shape (elements,)
        Shear modulus of each element [stress].
    before, after : array of float, shape (unknowns,)
        These displacements [length].
    graded : DisplacementSpace
        That of the graded mesh, whose elements are parts of those of `space`. Each element that a corner splits has
        the most of them.
    """
    change, parts = moduli * _squared_changes(space, before, after), _parts(space, graded)
    whole = float(change.sum())
    return float(change[parts < parts.max(initial=0)].sum()) / whole if whole else 0.0


def _squared_changes(space: DisplacementSpace, before: Array, after: Array) -> Array:
    """Return the integral of the squared change of Green's strain over each element, shape (elements,)."""
    start, end = (ngsolve.Grad(space.function(one)) + ngsolve.Id(space.dimension) for one in (before, after))
    change = (end.trans * end - start.trans * start) / 2
    squared = ngsolve.InnerProduct(change, change)
    return np.array(ngsolve.Integrate(squared, space.mesh, order=2 * space.order, element_wise=True))


def _parts(space: DisplacementSpace, finer: DisplacementSpace) -> NDArray[np.int64]:
    """Return how many elements of a finer mesh lie in each element, shape (elements,)."""
    place = np.array([vertex.point for vertex in finer.mesh.vertices])
    middle = [place[[vertex.nr for vertex in element.vertices]].mean(0) for element in finer.mesh.Elements()]
    with space.on_chords():
        number = space.mesh(*np.array(middle).T)["nr"]
    return np.bincount(number[number >= 0], minlength=space.mesh.ne)
