"""The lifting of filled tissues between plates: it keeps the volume, meets the plates, and leaves all others alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from ngcell.build.discretisation import Discretisation, discretise
from ngcell.geometry.bodies import LOWER_PLATE, UPPER_PLATE
from ngcell.mechanics.loading.constant_volume import Barrel, BarrellingMotion
from ngcell.mechanics.lumens.lumen import keeps_volume
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.scene import Case
from tests.prisms import case

FILLED = {"kind": "inclusion", "material": {"kind": "mooney-rivlin", "c1": 0.01, "c2": 0.0, "bulk_modulus": 10.0}}
FOAM = {"kind": "inclusion", "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 0.0, "bulk_modulus": 2.6}}
FLUID = {"kind": "fluid"}
STRETCHES = [0.3, 0.8, 1.2, 3.0]


def built(stretch: float, lumen: dict[str, Any] | None = None, *, height: float | None = None, **load: Any) -> Case:
    plates = {"kind": "plates", "levels": 1} | ({"stretch": stretch} if "displacement" not in load else {}) | load
    return case(height, load=plates, **({} if lumen is None else {"lumen": lumen}))


def followed(found: Discretisation, at: np.ndarray, load_factor: float) -> np.ndarray:
    """Where the lifting takes points of the tissue, which need be no vertices."""
    motion = found.motion
    assert isinstance(motion, BarrellingMotion)
    return at + motion.followed(at, load_factor)


@pytest.mark.parametrize("axes", [1, 2])
@pytest.mark.parametrize("stretch", STRETCHES)
def test_the_heights_of_sections_are_the_integral_of_what_keeps_their_volume(stretch, axes):
    barrel = Barrel.of_plates(stretch, axes)
    shares = np.linspace(0, 1, 6)
    found = barrel.height(shares)
    wanted = [quad(lambda t: float(barrel.stretch(np.array([t]))[0]) ** -axes, 0, share)[0] for share in shares]
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert found[-1] == pytest.approx(stretch, rel=1e-9)
    np.testing.assert_array_equal(barrel.stretch(np.array([0.0, 1.0])), 1.0)
    assert (barrel.size > 0) == (stretch < 1)


def test_the_barrelling_of_a_small_rise_is_that_of_a_bonded_block():
    """To first order sections stretch by 1.5 times the compression midway, as those of Gent and Lindley do."""
    assert Barrel.of_plates(1 - 1e-6, 1).size == pytest.approx(1.5e-6, rel=1e-5)
    assert Barrel.of_plates(1 - 1e-6, 2).size == pytest.approx(0.75e-6, rel=1e-5)


@pytest.mark.parametrize("load_factor", [0.5, 1.0])
@pytest.mark.parametrize(
    ("height", "load"), [(None, {}), (1.0, {}), (1.0, {"ends": "held"}), (1.0, {"ends": "mirrored"})]
)
@pytest.mark.parametrize("stretch", [0.8, 1.2])
def test_the_lifting_of_filled_cells_keeps_every_volume_on_the_way(stretch, height, load, load_factor):
    found = discretise(built(stretch, FILLED, height=height, **load))
    (low, high), dimension = found.space.bodies.extent, found.space.dimension
    inside = (low + (high - low) * np.random.default_rng(1).uniform(0.1, 0.9, (20, dimension))).T
    step = 1e-5
    columns = [
        (followed(found, inside + axis, load_factor) - followed(found, inside - axis, load_factor)) / (2 * step)
        for axis in step * np.eye(dimension)[:, :, None]
    ]
    gradients = np.transpose(columns, (2, 1, 0))
    np.testing.assert_allclose(np.linalg.det(gradients), 1, atol=1e-8)
    assert np.abs(gradients - np.eye(dimension)).max() > 0.05


@pytest.mark.parametrize("load_factor", [0.0, 0.5, 1.0])
def test_the_lifting_meets_the_plates_and_nothing_moves_without_load(load_factor):
    found = discretise(built(0.8, FILLED))
    motion, space = found.motion, found.space
    lifting = motion.lifting(load_factor).reshape(2, -1)
    for plate, rise in ((LOWER_PLATE, 0.0), (UPPER_PLATE, load_factor * found.prescribed_displacement[1])):
        unknowns = space.region_unknowns(plate)
        held = unknowns[space.one[unknowns] > 0]
        np.testing.assert_array_equal(lifting[0, held], 0)
        np.testing.assert_allclose(lifting[1, held], rise, atol=1e-14)
    assert lifting.any() == (load_factor > 0)


def test_mirrored_prisms_barrel_from_their_plane_of_symmetry():
    found = discretise(built(0.8, FILLED, height=1.0, ends="mirrored"))
    lifting, rest = found.motion.lifting(1.0).reshape(3, -1), found.space.rest
    below = (found.space.one > 0) & (rest[2] == 0)
    np.testing.assert_array_equal(lifting[2, below], 0)
    assert lifting[2, (found.space.one > 0) & (rest[2] == 1)].max() > 0.05


@pytest.mark.parametrize(
    ("lumen", "load"),
    [
        (None, {}),
        ({"kind": "pressure", "pressure": 0.01}, {}),
        (FOAM, {}),
        (FILLED, {"sides": "confined"}),
        (FILLED, {"displacement": (0.3, 0.0)}),
    ],
)
def test_other_liftings_are_those_of_a_sheet_to_the_bit(lumen, load):
    """Also of filled cells that confined sides keep from barrelling, and of plates that keep their distance."""
    scene = built(0.8, lumen, **load)
    found = discretise(scene)
    assert type(found.motion) is PrescribedMotion
    np.testing.assert_array_equal(found.motion.lifting(0.7), scene.load.motion(found.space).lifting(0.7))


def test_contents_that_rather_change_their_shape_keep_the_volume():
    contents = (FLUID, FILLED, FOAM, {"kind": "pressure", "pressure": 0.01})
    kept = [keeps_volume(built(0.8, each).lumen) for each in contents]
    assert kept == [True, True, False, False]
