"""From one mesh to a finer one: the displacement that was found becomes a function of the finer space."""

from __future__ import annotations

import ngsolve
import numpy as np

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.term import Array

#: Distance, in sizes of a body, below which two vertices are one.
_SAME = 1e-12


def transferred(displacement: Array, coarse: DisplacementSpace, fine: DisplacementSpace) -> Array:
    """Return a displacement as unknowns of a finer space, shape (unknowns,) [length].

    Where both have the same elements, unknowns are those of the reference element, so that curved elements may be
    curved by a higher order; bodies may overlap. Else elements of the finer mesh have to be parts of those of the
    coarse one, and bodies may touch. Elements that follow arcs are parts of each other on the chords of these.
    """
    old = coarse.function(displacement)
    if _same_elements(coarse, fine):
        # On the coarse mesh the finer space has the same unknowns.
        new = ngsolve.GridFunction(ngsolve.VectorH1(coarse.bodies.mesh, order=fine.order))
    else:
        new = ngsolve.GridFunction(fine.vector)
    with coarse.on_chords(), fine.on_chords():
        new.Set(old)
    return np.array(new.vec.FV().NumPy())


def _same_elements(one: DisplacementSpace, two: DisplacementSpace) -> bool:
    if one.bodies.mesh.ne != two.bodies.mesh.ne or one.bodies.mesh.nv != two.bodies.mesh.nv:
        return False
    here, there = (np.array([vertex.point for vertex in space.bodies.mesh.vertices]) for space in (one, two))
    return bool(np.abs(here - there).max() <= _SAME * one.bodies.length)
