"""Shape functions of boundary facets, sampled once for all facets with vertices in the same order."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.contact.surface.find import find_surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.space import DisplacementSpace
from tests.tissues import small_tissue


def prisms(order: int) -> DisplacementSpace:
    lattice = hexagonal_lattice(1, 2, side=1.0, pointy=True)
    section = ring_section(lattice.outlines, wall=0.1, radius=0.0, edges=1, layers=1, supports={})
    return DisplacementSpace(prism_mesh(section, height=0.7, slices=2), order)


@pytest.mark.parametrize(("space", "order"), [("cells", 1), ("cells", 2), ("cells", 5), ("prisms", 1), ("prisms", 3)])
def test_each_facet_has_its_own_shape_functions(space, order):
    found = small_tissue(2, 2, order=order).space if space == "cells" else prisms(order)
    walls = find_surface(found.bodies, found.scalar, found.rest)
    facets = list(found.mesh.Boundaries(found.bodies.wall_names).Elements())
    nodes = np.reshape(walls.basis.nodes, (len(walls.basis.nodes), -1))
    for facet, dofs, values in zip(facets, walls.dofs, walls.nodal, strict=True):
        assert list(found.scalar.GetDofNrs(facet)) == dofs.tolist()
        shape = found.scalar.GetFE(ngsolve.ElementId(ngsolve.BND, facet.nr)).CalcShape
        np.testing.assert_array_equal(values, [np.ravel(shape(*node)) for node in nodes])
