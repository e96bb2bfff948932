"""What a finer rule adds to the stored energy, against one that is finer still."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.build.simulation import Simulation
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.equilibrium import numbers_of
from ngcell.results.quadrature import quadrature_error
from ngcell.scene.reader import read_case
from ngcell.solve.proximal import ProximalTerm


def cell(order: int, *, filled: bool = False) -> DisplacementSpace:
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    bodies = ring_mesh(lattice.outlines, wall=0.2, radius=0.0, edges=2, layers=1, supports={}, filled=filled)
    return DisplacementSpace(bodies, order)


def bent(space: DisplacementSpace, size: float) -> np.ndarray:
    field = ngsolve.GridFunction(space.vector)
    x, y = ngsolve.x, ngsolve.y
    field.Set(size * ngsolve.CF((ngsolve.sin(4 * y) + x * y, ngsolve.cos(3 * x))))
    return np.array(field.vec.FV().NumPy())


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("kappa", [10.0, 1e4])
def test_the_error_is_that_against_a_much_finer_rule(order, kappa):
    space = cell(order)
    term = BodyEnergy(space, [MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=kappa)])
    at = space.configuration(bent(space, 0.03))
    exact = term.finer(40).form.energy(at.displacement)
    assert quadrature_error([term], at) == pytest.approx(abs(exact - term.value(at)), rel=0.02, abs=1e-9 * exact)


@pytest.mark.parametrize("rank", [0, 1, 2])
def test_on_triangles_a_finer_rule_is_judged_by_one_that_is_finer_still(rank):
    disc = mesh_shapes([occ.Circle((0, 0), 1.0).Face()], ["disc"], size=0.8, order=2)
    space = DisplacementSpace(disc, 2)
    term = BodyEnergy(space, [MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=1e3)])
    term.recall({"rule_of_bodies": np.array([rank])})
    at = space.configuration(bent(space, 0.2))
    exact = term.finer(60).form.energy(at.displacement)
    missed = abs(exact - term.value(at))
    assert missed > 1e-7 * exact
    assert quadrature_error([term], at) == pytest.approx(missed, rel=0.2)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_uniform_deformation_has_no_error(order):
    space = cell(order)
    term = BodyEnergy(space, [MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=1e6)])
    at = space.configuration(space.affine(np.diag([0.2, -0.1]), np.zeros(2)).ravel())
    assert quadrature_error([term], at) < 1e-10 * term.value(at)


def test_the_reduced_rule_of_an_inclusion_is_no_error():
    """Its volumetric part is under-integrated on purpose, and compared with itself."""
    space = cell(2, filled=True)
    at = space.configuration(bent(space, 0.02))
    soft, stiff = (InclusionEnergy(space, MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=kappa)) for kappa in (1.0, 1e6))
    assert stiff.value(at) > 100 * soft.value(at)
    assert quadrature_error([stiff], at) == pytest.approx(
        quadrature_error([soft], at), rel=1e-3, abs=1e-9 * stiff.value(at)
    )


def test_what_the_rule_misses_counts_in_the_error_of_the_energy():
    """So the accuracy that is asked for bounds it, wherever errors are estimated."""
    overrides = ["tissue.rows=1", "tissue.cols=2", "load.displacement=[0.3,0.0]", "load.levels=1", "accuracy=inf"]
    simulation = Simulation(read_case("shear-empty-3x3", [*overrides, "material.bulk_modulus=2e3", "expected=[]"]))
    *_, step = simulation.accepted_steps()
    problem, at = simulation.problem, simulation.space.configuration(step.checkpoint.displacement["released"])
    missed = quadrature_error(problem.terms, at)
    state = problem.at(at.displacement)
    besides = numbers_of(simulation.setup, problem, state, ProximalTerm(0.0, at.displacement)).besides
    assert missed > 1e-3 * step.record.energy
    assert besides == pytest.approx(missed + problem.overlap_work(at), rel=1e-9)
