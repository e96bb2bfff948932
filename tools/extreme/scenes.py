"""Cases of which points are made: tissues of few cells, rings in rings, blocks."""

from __future__ import annotations

from math import inf
from typing import Any

from tools.references import radial

Case = dict[str, Any]

#: Deviation from an exact answer above which a certified result counts as wrong. Meshes of these scenes are coarse.
WRONG = 0.02
#: Accuracy that is asked of scenes that leave the order of their elements open; others have the mesh that they give.
ACCURACY = 0.1

PENALTY, MORTAR = {"kind": "penalty"}, {"kind": "mortar"}
METHODS = {"penalty": PENALTY, "mortar": MORTAR}


def material(modulus: float = 2.0, bulk: float = 50.0, share: float = 0.5) -> Case:
    """Return a solid of this shear modulus, this ratio of bulk to shear modulus, and this share of c2 in the latter."""
    return {
        "kind": "mooney-rivlin",
        "c1": (1 - share) * modulus,
        "c2": share * modulus,
        "bulk_modulus": bulk * modulus,
    }


def tissue(
    rows: int = 2, cols: int = 2, wall: float = 0.1, *, move: tuple[float, float] = (0.3, 0.0), levels: Any = 1,
    contact: Case = PENALTY, **more: Any,
) -> Case:  # fmt: skip
    """A tissue between plates."""
    is_meshed = "order" in more.get("mesh", {})
    case: Case = {
        "tissue": {"rows": rows, "cols": cols, "wall": wall},
        "material": material(),
        "load": {"kind": "plates", "displacement": list(move), "levels": levels},
        "contact": dict(contact),
        "accuracy": inf if is_meshed else ACCURACY,
    }
    return case | more


def height(rows: int) -> float:
    """Distance of the plates of a tissue of this many rows of sides 1."""
    return 1.5 * (rows - 1) + 2.0


def rings(
    bore: float, rim: float = 1.5, *, pressure: float | None = None, moduli: tuple[float, float] = (1.0, 1.0),
    bulk: float = 1000.0, contact: Case = MORTAR, levels: Any = 1, order: int = 3, **more: Any,
) -> Case:  # fmt: skip
    """Quarters of a ring [0.5, 1] in a ring [bore, rim], pressed together by shape or by a pressure inside; exact."""
    solids = [radial.RadialSolid(modulus / 2, modulus / 2, bulk * modulus) for modulus in moduli]
    inside, outside = radial.Ring(solids[0], 0.5, 1.0), radial.Ring(solids[1], bore, rim)
    exact = radial.press_fit(inside, outside) if pressure is None else radial.closing(inside, outside, pressure)
    between = ["ring_outer", "hub_inner"]
    expected: list[Case] = [{"quantity": "mean_radius", "boundary": "ring_outer", "value": float(exact.inside.outer)}]
    if exact.gap < 1e-9:
        expected.append({"quantity": "contact_pressure", "between": between, "value": float(exact.contact_pressure)})
    else:
        expected.append({"quantity": "gap", "between": between, "value": float(exact.gap)})
    return {
        "levels": levels,
        "bodies": [
            _quarter("ring", 0.5, 1.0, 0.2, ["outer"], material(moduli[0], bulk)),
            _quarter("hub", bore, rim, 0.24, ["inner"], material(moduli[1], bulk)),
        ],
        "supports": [_sliding(body, side) for body in ("ring", "hub") for side in "xy"],
        "loads": [] if pressure is None else [{"kind": "pressure", "boundary": "ring_inner", "value": pressure}],
        "contact": dict(contact),
        "mesh": {"order": order},
        "accuracy": inf,
        "expected": [entry | {"tolerance": WRONG, "origin": "tools.references radial"} for entry in expected],
    } | more


def burst(pressure: float) -> Case:
    """A ring [0.5, 1] under a pressure that no radius balances, and far around it one that it may not touch."""
    far = rings(4.0, 4.5, pressure=0.1, levels=2, expected=[])
    walls = {"ring": ["outer"], "hub": []}
    return far | {
        "bodies": [body | {"walls": walls[body["name"]]} for body in far["bodies"]],
        "loads": [{"kind": "pressure", "boundary": "ring_inner", "value": pressure}],
    }


def _quarter(name: str, inner: float, outer: float, size: float, walls: list[str], solid: Case) -> Case:
    return {
        "name": name, "kind": "ring", "inner": inner, "outer": outer, "part": "upper-right", "size": size,
        "walls": walls, "material": solid,
    }  # fmt: skip


def _sliding(body: str, axis: str) -> Case:
    return {"boundary": f"{body}_{axis}0", "components": axis}


def blocks(
    moduli: tuple[float, float] = (1.0, 1.0), *, down: float = 0.2, gap: float = 0.0, contact: Case = MORTAR,
    sizes: tuple[float, float] = (0.25, 0.19), bulk: float = 50.0, width: float = 1.0, **more: Any,
) -> Case:  # fmt: skip
    """A block on a block, pressed together; their sides are free."""
    case: Case = {
        "levels": 1,
        "bodies": [
            {"name": "base", "kind": "block", "low": [0.0, 0.0], "high": [1.0, 1.0], "size": sizes[0],
             "material": material(moduli[0], bulk)},
            {"name": "top", "kind": "block", "low": [0.5 - width / 2, 1.0 + gap],
             "high": [0.5 + width / 2, 1.0 + gap + width], "size": sizes[1] * width,
             "material": material(moduli[1], bulk)},
        ],
        "supports": [
            {"boundary": "base_bottom"},
            {"boundary": "top_top", "translation": [0.0, -down - gap]},
        ],
        "contact": dict(contact),
        "mesh": {"order": 2},
        "accuracy": inf,
    }  # fmt: skip
    return case | more
