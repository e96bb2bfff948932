"""Groups of points whose numerics is extreme: penalties, units, overlaps, meshes, steps, paths, and prisms."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import sqrt

from tools.extreme import solids
from tools.extreme.point import Point
from tools.extreme.scenes import METHODS, blocks, material, rings, tissue


def penalties() -> Iterator[Point]:
    """Stiffness of the penalty over its default."""
    for multiple in (1e-2, 1e-1, 1e1, 1e2, 1e3, 1e4, 1e6):
        stiff = {"kind": "penalty", "stiffness": multiple}
        yield Point("penalty", f"{multiple:.0e} tissue", partial(tissue, contact=stiff))
        yield Point("penalty", f"{multiple:.0e} press-fit", partial(rings, 0.9, contact=stiff))


def units() -> Iterator[Point]:
    """The same tissue in other units of length and stress."""
    for name, contact in METHODS.items():
        for word, length, stress in (
            ("m and Pa", 1.0, 1.0), ("um and MPa", 1e6, 1e-6), ("km and GPa", 1e-3, 1e-9),
            ("m and Pa of um and MPa", 1e-6, 1e6),
        ):  # fmt: skip
            cells = {"rows": 2, "cols": 2, "side": length, "wall": 0.1 * length}
            case = partial(
                tissue, move=(0.3 * length, 0.0), contact=contact, material=material(2.0 * stress), tissue=cells
            )
            yield Point("units", f"{word}, {name}", case, same_as=f"m and Pa, {name}", units=(length, stress))


def overlaps_and_gaps() -> Iterator[Point]:
    """Bodies drawn into each other, and apart."""
    for bore in (0.99, 0.8, 0.7, 0.6):
        for name, contact in METHODS.items():
            case = partial(rings, bore, bore + 0.6, contact=contact)
            yield Point("overlap and gap", f"overlap {1 - bore:g}, {name}", case)
    for bore in (1.001, 1.1, 1.5):
        for name, contact in METHODS.items():
            case = partial(rings, bore, bore + 0.5, pressure=0.68, contact=contact, levels=2)
            yield Point("overlap and gap", f"gap {bore - 1:.3g}, {name}", case)
    for gap in (1e-6, 0.5):
        yield Point("overlap and gap", f"blocks {gap:g} apart", partial(blocks, gap=gap))


def bad_meshes() -> Iterator[Point]:
    """Needles and grading."""
    for size, layers in ((1.0, 1), (1.0, 8), (0.5, 16), (0.02, 1)):
        for name, contact in METHODS.items():
            mesh = {"size": size, "layers": layers, "order": 2}
            yield Point(
                "mesh", f"size {size:g}, {layers} layers, {name}", partial(tissue, 1, 2, contact=contact, mesh=mesh)
            )
    for size in (1e-2, 1e-3):
        for name, contact in METHODS.items():
            graded = {"order": 2, "refine": [{"at": [1.0, 1.0], "within": size, "size": size / 2}]}
            yield Point("mesh", f"graded to {size:g}, {name}", partial(blocks, contact=contact, mesh=graded))
    for sizes in ((0.5, 0.02), (0.02, 0.5)):
        for name, contact in METHODS.items():
            yield Point("mesh", f"{sizes[0]:g} on {sizes[1]:g}, {name}", partial(blocks, sizes=sizes, contact=contact))


def unequal_sizes() -> Iterator[Point]:
    """Bodies of very different size."""
    for width in (0.1, 0.01, 0.001):
        for name, contact in METHODS.items():
            case = partial(blocks, width=width, down=0.1 * width, contact=contact)
            yield Point("unequal sizes", f"{width:g} on 1, {name}", case)


def step_counts() -> Iterator[Point]:
    """One load step, and two hundred."""
    for steps in (1, 200):
        for strategy in ("sddp", "single-step"):
            case = partial(tissue, 1, 2, strategy={"kind": strategy, "steps": steps}, mesh={"order": 2})
            yield Point("steps", f"{steps}, {strategy}", case, same_as=f"1, {strategy}")
    for steps in (1, 50):
        case = partial(rings, 1.1, 1.6, pressure=0.68, steps=steps)
        yield Point("steps", f"{steps}, closing rings", case)


def there_and_back() -> Iterator[Point]:
    """The load taken back: no energy is left."""
    for strategy in ("sddp", "single-step"):
        for name, contact in METHODS.items():
            rest = {
                "level": 0.0,
                "quantity": "energy",
                "value": 0.0,
                "tolerance": 1e-10,
                "origin": "no law of debonding",
            }
            case = partial(
                tissue, 2, 2, move=(sqrt(3), 0.0), levels=[0.5, 1.0, 0.5, 0.0], contact=contact, mesh={"order": 2},
                strategy={"kind": strategy}, expected=[rest],
            )  # fmt: skip
            yield Point("there and back", f"{strategy}, {name}", case)


def prisms() -> Iterator[Point]:
    """Prisms: flat and tall, thin and stiff, closed and turned."""
    for setting, case, same_as in solids.entries():
        yield Point("prisms", setting, case, same_as=same_as)


#: In the order of the map.
GROUPS = (penalties, units, overlaps_and_gaps, bad_meshes, unequal_sizes, step_counts, there_and_back, prisms)
