"""The force of a support, apart from those of supports beside it.

Reactions are forces on unknowns. Where two supports share a vertex, the function of that vertex reaches along both, and
the sum over the unknowns of one has the forces that the other bears next to it: half of an element's worth, whatever
the order. So the sum is continued along the other support by functions that vanish at its vertices, with weights that
make the whole orthogonal to polynomials of two orders less there. What is left of the other's forces is as small as
such polynomials approximate them.
"""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.space import DisplacementSpace, csr_matrix

Array = NDArray[np.float64]


def weights_of_resultant(space: DisplacementSpace, region: str, beside: str) -> Array:
    """Return the weights with which nodal forces add up to the force on a region, shape (size,).

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    region : str
        Name of the boundary region, or a regular expression.
    beside : str
        Those of all supports that prescribe this component of the displacement; empty if there are none.

    Notes
    -----
    In three dimensions, and with elements of order 1, the sum is over the region's unknowns alone.
    """
    mine = space.region_unknowns(region)
    weights = np.zeros(space.size)
    weights[mine] = space.one[mine]
    if space.dimension != 2 or space.order < 2 or not beside:
        return weights
    others = space.mesh.Boundaries(beside) - space.mesh.Boundaries(region)
    if not np.intersect1d(mine, space.region_unknowns(others)).size:
        return weights
    polynomials = ngsolve.SurfaceL2(space.mesh, order=space.order - 2, definedon=others)
    trial, test = space.scalar.TrialFunction(), polynomials.TestFunction()
    form = ngsolve.BilinearForm(trialspace=space.scalar, testspace=polynomials)
    form += trial * test * ngsolve.ds(definedon=others)
    form.Assemble()
    products = csr_matrix(form.mat)
    for element in others.Elements():
        unknowns = np.array(space.scalar.GetDofNrs(element))
        if np.isin(unknowns, mine).any():
            bubbles = unknowns[unknowns >= space.mesh.nv]
            rows = products[np.array(polynomials.GetDofNrs(element))]
            weights[bubbles] = -np.linalg.lstsq(rows[:, bubbles].toarray(), rows @ weights, rcond=None)[0]
    return weights
