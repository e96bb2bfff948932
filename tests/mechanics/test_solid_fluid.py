"""Fluids in closed prisms: volumes, and an energy with its derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.fluid import LumenFluids
from ngcell.mechanics.space import DisplacementSpace

LATTICE = hexagonal_lattice(1, 2, side=1.0, pointy=True)
WALL, HEIGHT, END = 0.2, 0.8, 0.15
STEPS = np.array([8e-3, 4e-3, 2e-3])


def closed_cells(order: int = 2, layers: int = 1) -> DisplacementSpace:
    choices = {"wall": WALL, "radius": 0.0, "edges": 1, "layers": 1, "supports": {}, "closed": True}
    bodies = prism_mesh(*[ring_section(LATTICE.outlines, **choices)] * layers, height=HEIGHT, slices=1, end_wall=END)
    return DisplacementSpace(bodies, order)


def fluids(space: DisplacementSpace, **options: float) -> LumenFluids:
    found = LumenFluids(space, "lumen", **({"modulus": 0.7} | options))
    found.apply(1.0)
    return found


def smooth(space: DisplacementSpace, amplitude: float, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    x, y, z = space.rest
    noise = random.standard_normal(space.size) / 20
    terms = np.array([space.one, x, y, z, space.one * x * y, space.one * y * z, noise])
    return amplitude * (random.standard_normal((3, len(terms))) @ terms).ravel()


@pytest.mark.parametrize("order", [1, 2, 3])
def test_volumes_follow_an_affine_map_exactly(order):
    space = closed_cells(order, layers=2)
    found = fluids(space)
    inside = 1.5 * np.sqrt(3) * (1 - WALL / (np.sqrt(3) / 2)) ** 2 * (HEIGHT - 2 * END)
    assert found.body.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(found.area, inside, rtol=1e-12)
    gradient = np.array([[0.2, 0.3, -0.1], [-0.1, 0.4, 0.2], [0.05, -0.3, 0.1]])
    moved = space.affine(gradient, np.array([0.3, -5.0, 2.0])).ravel()
    np.testing.assert_allclose(found.areas(moved), np.linalg.det(np.eye(3) + gradient) * inside, rtol=1e-11)


@pytest.mark.parametrize("order", [1, 2])
def test_taylor_remainders_of_energy_and_forces_vanish_at_their_rates(order):
    space = closed_cells(order)
    found = fluids(space, fill=1.1)
    found.pressure = np.array([0.3, -0.2])
    at, way = smooth(space, 0.1, 1), smooth(space, 0.5, 2)
    rows, columns = found.pattern
    assert (rows >= columns).all()
    assert len(set(zip(rows, columns, strict=True))) == len(rows)
    matrix = np.zeros((space.unknowns,) * 2)
    matrix[rows, columns] = found.tangent(space.configuration(at))
    bent = (matrix + np.tril(matrix, -1).T) @ way
    here, ahead = space.configuration(at), [space.configuration(at + h * way) for h in STEPS]
    slope, rise = found.gradient(here), np.array([found.value(there) for there in ahead]) - found.value(here)
    first = np.abs(rise - STEPS * (slope @ way))
    second = np.abs(rise - STEPS * (slope @ way) - STEPS**2 / 2 * (way @ bent))
    forces = [np.linalg.norm(found.gradient(there) - slope - h * bent) for h, there in zip(STEPS, ahead, strict=True)]
    for remainders, rate in ((first, 2), (second, 3), (forces, 2)):
        np.testing.assert_allclose(np.log2(np.array(remainders[:-1]) / remainders[1:]), rate, atol=0.15)


def test_forces_of_a_fluid_balance_and_are_those_of_its_pressure():
    space = closed_cells()
    found = fluids(space)
    state = smooth(space, 0.1, 4)
    force = found.gradient(space.configuration(state)).reshape(3, -1)
    np.testing.assert_allclose(force @ space.one, 0, atol=1e-12 * np.abs(force).max())
    # The virtual work on a field that blows the lumens up is minus the pressures times the rise of their volumes.
    grow = space.rest + state.reshape(3, -1)
    meant = -3 * found.pressures(state) @ found.areas(state)
    assert (force * grow).sum() == pytest.approx(meant, rel=1e-10)
