"""Utilisation of walls: a plate with a hole and rings under pressure in closed form, units, and finer meshes."""

from __future__ import annotations

from math import inf

import ngsolve
import numpy as np
import pytest

from ngcell import read_case, simulate
from ngcell.build.reported import Step
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.sections import ring_mesh
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.rupture.load import RuptureLoad, rupture_load
from ngcell.results.rupture.strength import WallStrength, wall_strength
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin
from tests.physics.rig import ring
from tools.references.averages import HoledPlate, InflatedRing, largest_at_hole
from tools.references.radial import RadialSolid, profile

HOLE, RIM, LENGTH, STRAIN = 1.0, 4.0, 0.5, 1e-5


def holed_plate(size: float) -> BodyScene:
    """A ring with a free hole, whose rim is strained affinely: small strain."""
    law = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=13 / 6, strength=1.0, rupture_length=LENGTH)
    shape = ring(HOLE, RIM)
    for edge in shape.edges:
        edge.name = "rim" if max(abs(edge.start.x), abs(edge.start.y)) > 2 else "hole"
    support = BodySupport("rim", gradient=((0.35 * STRAIN, 0.0), (0.0, -0.15 * STRAIN)))
    return BodyScene([Body(shape, law, "plate")], [support], size=size, order=3, levels=1, accuracy=inf)


def test_a_plate_with_a_hole_bears_the_average_of_the_exact_stress():
    step = simulate(holed_plate(0.25))[-1]
    plate = HoledPlate(HOLE, RIM, (0.35 * STRAIN, -0.15 * STRAIN), 1.0, 13 / 6)
    assert step.record.more["utilisation"] == pytest.approx(largest_at_hole(plate, LENGTH), rel=2e-3)
    assert abs(step.record.more["utilisation_x"]) < 0.1
    assert abs(step.record.more["utilisation_y"]) == pytest.approx(HOLE, abs=0.1)


def test_the_exact_plate_tends_to_that_of_kirsch():
    plate = HoledPlate(1.0, 1e5, (0.35, -0.15), 1.0, 13 / 6)  # remote stress 1 along x, nu = 0.3
    at_hole = plate.stress(np.ones(2), np.array([np.pi / 2, 0.0]))[1]
    np.testing.assert_allclose(at_hole, [3.0, -1.0], rtol=1e-7)
    assert largest_at_hole(plate, 1e-3) == pytest.approx(3.0, rel=3e-3)


@pytest.mark.parametrize(("kappa", "error"), [(100.0, 2e-4), (900.0, 1e-3)])
def test_an_inflated_ring_bears_the_average_of_the_radial_solution(kappa: float, error: float):
    """Finite strain: the bore is driven to where the radial solution has it under a pressure. With the volume ratio of
    the displacement alone, errors are 3.2e-4 and 3.6e-3."""
    exact = InflatedRing(RadialSolid(0.5, 0.5, kappa), 1.0, 1.2, 0.08)
    law = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=kappa, strength=1.0, rupture_length=0.2)
    shape = ring(1.0, 1.2)
    for edge in shape.edges:
        edge.name = "bore" if edge.start.x**2 + edge.start.y**2 < 1.2 else "rim"
    growth = exact.radii[0] - 1
    support = BodySupport("bore", gradient=((growth, 0.0), (0.0, growth)))
    scene = BodyScene([Body(shape, law, "ring")], [support], size=0.15, order=3, levels=2, accuracy=inf)
    assert simulate(scene)[-1].record.more["utilisation"] == pytest.approx(exact.average(0.2), rel=error)


def polygonal_ring(corners: int, grading: int) -> DisplacementSpace:
    """A swept cell of so many sides around a lumen with sides at the radius 1 and a wall of 0.2."""
    angle, outer = 2 * np.pi * np.arange(corners) / corners, 1.2 / np.cos(np.pi / corners)
    outline = outer * np.column_stack([np.cos(angle), np.sin(angle)])
    outlines = Outlines(outline, np.array([corners]), np.full(corners, -1))
    bodies = ring_mesh(outlines, wall=0.2, radius=0.0, edges=1, layers=2, grading=grading, supports={})
    return DisplacementSpace(bodies, 4)


@pytest.mark.parametrize("grading", [0, 2])
def test_a_swept_wall_under_pressure_bears_the_mean_over_its_thickness(grading: int):
    """Balance of forces: P a / (b - a), over a length of the wall in which the hoop stress hardly changes direction."""
    exact = InflatedRing(RadialSolid(0.5, 0.5, 100.0), 1.0, 1.2, 0.08)
    space = polygonal_ring(48, grading)
    knots = np.linspace(1.0, 1.21, 50)
    stretch = profile(exact.solid, 1.0, 1.21, exact.radii[0], exact.pressure)(knots)[0] / knots
    fit = np.polynomial.Polynomial.fit(knots, stretch, 9).convert().coef
    radius, moved = ngsolve.sqrt(ngsolve.x**2 + ngsolve.y**2), ngsolve.GridFunction(space.vector)
    ratio = sum(float(one) * radius**power for power, one in enumerate(fit))
    moved.Set(ngsolve.CF((ngsolve.x, ngsolve.y)) * (ratio - 1))
    law = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=100.0, strength=1.0, rupture_length=0.05)
    strength = wall_strength(space, [law])
    assert isinstance(strength, WallStrength)
    found = strength.utilisation([BodyEnergy(space, [law])], np.array(moved.vec.FV().NumPy()))
    assert found.of_body[0] == pytest.approx(exact.mean_hoop, rel=5e-3)


#: Four cells and two, sheared.
FOUR = ("tissue.rows=2", "tissue.cols=2", "load.displacement=[0.5, 0.0]")
PAIR = ("tissue.rows=1", "tissue.cols=2", "load.displacement=[0.3, 0.0]")


def tissue(*sets: str) -> list[Step]:
    return simulate(read_case("shear-empty-3x3", ["expected=[]", *sets]))


@pytest.mark.parametrize("ratio", [20.0, 300.0])
def test_a_cell_under_pressure_bears_what_finer_elements_say(ratio: float):
    """With the volume ratio of the displacement alone it is 1.2 and 5.7 times as much at order 3."""
    bulk = f"material.bulk_modulus={2 * ratio!r}"
    cell = ("tissue.rows=1", "lumen.kind=pressure", "lumen.pressure=0.02", "load.displacement=[0.2, 0.0]", bulk)
    single = ("tissue.cols=2", "load.levels=1", "accuracy=inf", "material.strength=0.1")
    usual, fine = (tissue(*cell, *single, f"mesh.order={order}")[-1].record.more["utilisation"] for order in (3, 6))
    assert usual == pytest.approx(fine, rel=0.05)


def predicted(*sets: str, strength: float = 0.03) -> RuptureLoad:
    steps = tissue("load.levels=2", f"material.strength={strength}", *sets)
    found = rupture_load([step.record for step in steps], starts_at_rest=True)
    assert found is not None
    return found


def test_a_finer_mesh_moves_the_load_by_less_than_its_error():
    usual, fine = predicted(*FOUR, "accuracy=0.1"), predicted(*FOUR, "accuracy=0.01")
    assert 0 < fine.error < usual.error < 0.1 * usual.load_factor
    assert abs(usual.load_factor - fine.load_factor) < usual.error
    assert fine.cell == usual.cell


def test_loads_do_not_depend_on_units():
    """Lengths times 4, stresses times 8."""
    large = (
        "tissue.rows=1", "tissue.cols=2", "tissue.side=4.0", "tissue.wall=0.4", "load.displacement=[1.2, 0.0]",
        "material.c1=8.0", "material.c2=8.0", "material.bulk_modulus=800.0", "accuracy=0.1",
    )  # fmt: skip
    one, two = predicted(*PAIR, "accuracy=0.1", strength=0.01), predicted(*large, strength=0.08)
    assert two.load_factor == pytest.approx(one.load_factor, rel=1e-9)
    assert two.error == pytest.approx(one.error, rel=1e-6)
    assert two.cell == one.cell
    np.testing.assert_allclose(two.place, 4 * np.array(one.place), rtol=1e-9)


def test_averages_converge_where_the_largest_stress_does_not():
    """Elements that shrink towards the corners of lumens."""
    averages, peaks = [], []
    for grading in (1, 2, 3):
        sets = ("mesh.order=3", f"mesh.grading={grading}", "load.levels=1", "accuracy=inf")
        step = tissue(*FOUR, *sets, "material.strength=1.0")[-1]
        averages.append(step.record.more["utilisation"])
        peaks.append(np.linalg.eigvalsh(step.snapshot.bulk.point_data["cauchy_stress"].reshape(-1, 3, 3))[:, -1].max())
    assert peaks[2] > 1.3 * peaks[1] > 1.3**2 * peaks[0]
    assert abs(averages[1] - averages[0]) < 0.03 * averages[0]
    assert abs(averages[2] - averages[1]) < 0.1 * abs(averages[1] - averages[0])
