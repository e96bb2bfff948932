"""Prisms far outside comfort: settings, cases, and what must agree."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from tools.extreme.scenes import Case, height, material, tissue

#: A setting, its case, and the setting that must give the same numbers, if there is one.
Entry = tuple[str, partial[Case], str]


def prisms(
    rows: int = 1, cols: int = 2, wall: float = 0.1, *, tall: float = 1.0, size: float = 0.5, slices: int = 1,
    end_wall: float | None = None, ends: str | None = None, load: Case | None = None,
    move: tuple[float, float] = (0.2, 0.0), **more: Any,
) -> Case:  # fmt: skip
    """A tissue of prisms, sheared between plates or moved at its ends."""
    case = tissue(rows, cols, wall, move=move, mesh={"order": 2, "size": size, "slices": slices}, **more)
    case["tissue"] |= {"height": tall} | ({} if end_wall is None else {"end_wall": end_wall})
    case["load"] = load or case["load"] | ({} if ends is None else {"ends": ends})
    return case


def flat_and_tall() -> Iterator[Entry]:
    """Heights from half a wall to twenty sides; those held along their axis are the planar cells."""
    yield "planar", partial(tissue, 1, 2, move=(0.2, 0.0), mesh={"order": 2, "size": 0.5}), "planar"
    yield "height 1, held", partial(prisms, ends="held"), "planar"
    for tall, slices in ((0.05, 1), (0.2, 1), (1.0, 2), (5.0, 4), (20.0, 8)):
        yield f"height {tall:g}", partial(prisms, tall=tall, slices=slices), ""


def thin_stiff_and_far() -> Iterator[Entry]:
    """Thin walls, volumes that hardly change, and shear to 100 %."""
    for wall in (0.02, 0.05, 0.3):
        yield f"wall {wall:g}", partial(prisms, wall=wall), ""
    for bulk in (1.0, 1e4, 1e6):
        yield f"bulk / shear {bulk:.0e}", partial(prisms, material=material(bulk=bulk)), ""
    for shear in (0.5, 1.0):
        yield f"shear {shear:g}", partial(prisms, 2, 2, move=(shear * height(2), 0.0)), ""


def closed_and_turned() -> Iterator[Entry]:
    """Closed cells under pressure, and ends turned far."""
    for pressure in (0.05, 0.2):
        pressed = {"kind": "pressure", "pressure": pressure}
        yield f"closed, pressure {pressure:g}", partial(prisms, end_wall=0.1, lumen=pressed), ""
    for twist in (45.0, 90.0):
        turned = {"kind": "ends", "twist": twist, "levels": 2}
        yield f"twist {twist:g}", partial(prisms, tall=2.0, slices=4, load=turned), ""
    for bend in (30.0, 90.0):
        bent = {"kind": "ends", "bend": bend, "levels": 2}
        yield f"bend {bend:g}", partial(prisms, tall=4.0, slices=6, load=bent), ""
    for stretch, size, slices in ((-0.3, 0.25, 8), (1.0, 0.5, 2)):  # walls that buckle take elements of half the size
        pulled = {"kind": "ends", "displacement": [0.0, 0.0, stretch], "levels": 2}
        yield f"axis stretched by {stretch:g}", partial(prisms, size=size, slices=slices, load=pulled), ""


def entries() -> Iterator[Entry]:
    """Yield all of them."""
    for group in (flat_and_tall, thin_stiff_and_far, closed_and_turned):
        yield from group()
