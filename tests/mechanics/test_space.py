"""Reference coordinates as unknowns: on straight elements of any shape, and on curved ones."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_mesh, ring_section
from ngcell.mechanics.space import DisplacementSpace

LATTICE = hexagonal_lattice(1, 2, side=1.0, pointy=True)


def section(radius: float) -> DisplacementSpace:
    mesh = ring_mesh(LATTICE.outlines, wall=0.1, radius=radius, edges=2, layers=1, grading=2, supports={}, filled=True)
    return DisplacementSpace(mesh, 4)


def prisms(radius: float) -> DisplacementSpace:
    flat = ring_section(LATTICE.outlines, wall=0.1, radius=radius, edges=1, layers=1, grading=1, supports={})
    return DisplacementSpace(prism_mesh(flat, height=0.7, slices=1), 3)


@pytest.mark.parametrize("of", [section, prisms])
@pytest.mark.parametrize("radius", [0.0, 0.15])
def test_unknowns_at_rest_are_the_coordinates(of, radius):
    space = of(radius)
    place, scale = ngsolve.GridFunction(space.vector), space.bodies.length
    place.vec.FV().NumPy()[:] = space.rest.ravel()
    coordinates = ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z)[: space.dimension])
    away = ngsolve.Integrate((place - coordinates) ** 2, space.mesh, order=10)
    assert np.sqrt(away) < 1e-12 * scale
    if not radius:
        assert not space.rest[:, space.mesh.nv :].any()
