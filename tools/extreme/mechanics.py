"""Groups of points whose mechanics is extreme: thin walls, stiff solids, far loads, pressures past what walls bear."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import log

from tools.extreme.point import Point
from tools.extreme.scenes import METHODS, MORTAR, WRONG, blocks, burst, height, material, rings, tissue


def thin_and_thick_walls() -> Iterator[Point]:
    """Wall over side."""
    for wall in (0.01, 0.02, 0.05, 0.2, 0.35, 0.5):
        for name, contact in METHODS.items():
            yield Point("wall / side", f"{wall:g}, {name}", partial(tissue, wall=wall, contact=contact))


def stiff_volumes() -> Iterator[Point]:
    """Bulk over shear modulus."""
    for bulk in (1.0, 1e2, 1e3, 1e4, 1e5, 1e6):
        for name, contact in METHODS.items():
            case = partial(tissue, contact=contact, material=material(bulk=bulk))
            yield Point("bulk / shear", f"{bulk:.0e} tissue, {name}", case)
    for bulk in (1.0, 1e2, 1e4, 1e6):
        for name, contact in METHODS.items():
            case = partial(rings, 0.9, bulk=bulk, contact=contact)
            yield Point("bulk / shear", f"{bulk:.0e} press-fit, {name}", case)


def stiff_fillings() -> Iterator[Point]:
    """Shear modulus of what fills the lumens over that of the walls."""
    for ratio in (1e-4, 1e-2, 1.0, 1e2, 1e4):
        for name, contact in METHODS.items():
            filling = {"kind": "inclusion", "material": material(2.0 * ratio)}
            yield Point(
                "inclusion / wall",
                f"{ratio:.0e}, {name}",
                partial(tissue, move=(0.05, 0.0), contact=contact, lumen=filling),
            )
    for bulk in (1e4, 1e6):
        filling = {"kind": "inclusion", "material": material(0.2, bulk)}
        yield Point("inclusion / wall", f"0.1 with bulk / shear {bulk:.0e}", partial(tissue, lumen=filling))


def stiff_neighbours() -> Iterator[Point]:
    """One wall stiffer than its neighbour."""
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        for name, contact in METHODS.items():
            case = partial(rings, 0.96, moduli=(1.0, ratio), contact=contact)
            yield Point("stiff neighbour", f"{ratio:.0e} press-fit, {name}", case)
    for ratio in (1e-6, 1e6):
        for name, contact in METHODS.items():
            case = partial(blocks, (1.0, ratio), contact=contact)
            yield Point("stiff neighbour", f"{ratio:.0e} blocks, {name}", case)


def second_constants() -> Iterator[Point]:
    """c2 over c1."""
    for ratio in (0.0, 1.0, 10.0, 100.0):
        case = partial(tissue, material=material(share=ratio / (1 + ratio)))
        yield Point("c2 / c1", f"{ratio:g}", case)


def far_shear() -> Iterator[Point]:
    """Plates moved by up to twice their distance, and a frame sheared as far."""
    for shear in (0.5, 1.0, 2.0, -2.0):
        for name, contact in METHODS.items():
            case = partial(tissue, move=(shear * height(2), 0.0), contact=contact, levels=2)
            yield Point("shear", f"{shear:g} plates, {name}", case)
    for shear in (1.0, 2.0, -2.0):
        for name, contact in METHODS.items():
            case = partial(tissue, contact=contact, load={"kind": "frame", "shear": shear, "levels": 2})
            yield Point("shear", f"{shear:g} frame, {name}", case)


def crushed() -> Iterator[Point]:
    """The tissue pressed to half of its height."""
    for stretch in (0.9, 0.75, 0.5):
        for name, contact in METHODS.items():
            case = partial(tissue, contact=contact, load={"kind": "plates", "stretch": stretch, "levels": 2})
            yield Point("compression", f"{stretch:g} plates, {name}", case)
    for stretch in (0.75, 0.5):
        frame = {"kind": "frame", "stretch": [1.0, stretch], "levels": 2}
        yield Point("compression", f"{stretch:g} frame, penalty", partial(tissue, load=frame))
    for stretch in (0.9, 0.75, 0.5):
        frame = {"kind": "frame", "stretch": [stretch, stretch], "levels": 2}
        yield Point("compression", f"{stretch:g} frame, both ways", partial(tissue, load=frame))


def swollen() -> Iterator[Point]:
    """Pressures up to and past the one that a wall can bear.

    A ring of radii A, B in plane strain bears no more than ``mu ln(B / A)`` if it is incompressible: its radius grows
    beyond bounds as the pressure comes near. At this ratio of bulk to shear modulus the bound differs by its inverse.
    """
    limit = log(2.0)
    for share in (0.5, 0.9, 0.98):
        case = partial(rings, 4.0, 4.5, pressure=share * limit, levels=2)
        yield Point("cell pressure", f"{share:g} of a ring's limit", case)
    for share in (1.1, 2.0, 10.0):
        yield Point("cell pressure", f"{share:g} of a ring's limit", partial(burst, share * limit), has_solution=False)
    for pressure in (0.02, 0.1):
        for name, contact in METHODS.items():
            lumen = {"kind": "pressure", "pressure": pressure, "ramp": "first"}
            yield Point(
                "cell pressure", f"tissue {pressure:g}, {name}", partial(tissue, contact=contact, lumen=lumen, levels=2)
            )
    # Free walls of the outer cells bear about mu times wall over radius, 0.2, and no more.
    for pressure in (0.5, 2.0):
        lumen = {"kind": "pressure", "pressure": pressure}
        case = partial(tissue, lumen=lumen, levels=4)
        yield Point("cell pressure", f"tissue {pressure:g}", case, has_solution=False)
    lumen = {"kind": "pressure", "pressure": 2.0}
    case = partial(tissue, 1, 2, lumen=lumen)
    yield Point("cell pressure", "a pair of cells 2", case, has_solution=False)
    for pressure in (0.2, 5.0, 50.0):
        # Held all around, walls between cells of one pressure bear it without bending.
        walls = 5 * 1.0
        exact = {
            "level": 1.0,
            "quantity": "contact_force",
            "value": walls * pressure,
            "tolerance": WRONG,
            "origin": "walls that are held bear the pressure of their cells",
        }
        case = partial(
                tissue, lumen={"kind": "pressure", "pressure": pressure}, material=material(bulk=1e4), contact=MORTAR,
            load={"kind": "frame", "shear": 0.0, "levels": 1}, expected=[exact],
        )  # fmt: skip
        yield Point("cell pressure", f"held tissue {pressure:g}", case)


#: In the order of the map.
GROUPS = (
    thin_and_thick_walls, stiff_volumes, stiff_fillings, stiff_neighbours, second_constants, far_shear, crushed,
    swollen,
)  # fmt: skip
