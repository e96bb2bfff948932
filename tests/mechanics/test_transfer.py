"""From a mesh to a finer one: a displacement stays the function that it was."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_mesh, ring_section
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.transfer import transferred

LATTICE = hexagonal_lattice(2, 2, side=1.0, pointy=True)


def space(order: int, grading: int, radius: float = 0.0, *, filled: bool = False) -> DisplacementSpace:
    mesh = ring_mesh(
        LATTICE.outlines, wall=0.1, radius=radius, edges=2, layers=1, grading=grading, supports={}, filled=filled
    )
    return DisplacementSpace(mesh, order)


def prisms(order: int, grading: int) -> DisplacementSpace:
    section = ring_section(LATTICE.outlines, wall=0.1, radius=0.0, edges=1, layers=1, grading=grading, supports={})
    return DisplacementSpace(prism_mesh(section, height=0.7, slices=1), order)


def difference(one: DisplacementSpace, u: np.ndarray, two: DisplacementSpace, v: np.ndarray) -> float:
    """Norm of the difference, integrated on the finer mesh, over the norm; on the chords where elements follow arcs."""
    coarse, fine = one.function(u), two.function(v)
    with one.on_chords(), two.on_chords():
        away = ngsolve.Integrate(ngsolve.InnerProduct(fine - coarse, fine - coarse), two.bodies.mesh, order=10)
        whole = ngsolve.Integrate(ngsolve.InnerProduct(fine, fine), two.bodies.mesh, order=10)
    return float(np.sqrt(away / whole))


@pytest.mark.parametrize(
    ("coarse", "fine"),
    [
        (space(2, 1), space(3, 1)),
        (space(3, 1), space(4, 2)),
        (space(4, 2), space(5, 3)),
        (space(3, 1, radius=0.2), space(4, 2, radius=0.2)),
        (space(2, 1, filled=True), space(3, 2, filled=True)),
        (prisms(2, 1), prisms(2, 2)),
    ],
)
def test_a_displacement_stays_the_same_function(coarse: DisplacementSpace, fine: DisplacementSpace):
    u = 0.1 * np.random.default_rng(1).standard_normal(coarse.unknowns)
    assert difference(coarse, u, fine, transferred(u, coarse, fine)) < 1e-12


def test_bodies_that_touch_keep_their_own_displacements():
    coarse, fine = space(2, 1), space(3, 2)
    u = (coarse.body_of_unknown * coarse.one)[None] * np.ones((2, 1))
    v = transferred(u.ravel(), coarse, fine).reshape(2, -1)
    assert np.abs(v - fine.body_of_unknown * fine.one).max() < 1e-10
