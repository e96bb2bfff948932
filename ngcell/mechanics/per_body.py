"""Integrals over the elements of each body."""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.symbolic import SymbolicTerm
from ngcell.mechanics.term import Configuration

Array = NDArray[np.float64]


def in_bodies(term: SymbolicTerm, at: Configuration) -> Array:
    """Return what integrals over elements add up to in each body, shape (bodies,)."""
    found = term.integrals(term.space.function(at.displacement))
    return np.asarray(sum(by_body(term.space, each) for each in found))


def by_body(space: DisplacementSpace, integral: ngsolve.comp.SumOfIntegrals) -> Array:
    """Return the part of an integral in each body, shape (bodies,)."""
    values, body = np.array(ngsolve.Integrate(integral, space.mesh, element_wise=True)), space.bodies.body_of_element
    return np.asarray(np.bincount(body, values, space.body_count), dtype=float)
