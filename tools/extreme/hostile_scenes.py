"""A hundred and fifty small scenes, drawn at random from a seed, each with what must hold of it.

A scene is drawn by its number alone, so that any of them can be run again without those before it.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field
from math import inf, sqrt
from typing import Any

import numpy as np

Case = dict[str, Any]
Draw = np.random.Generator
SEED = 2026


@dataclass(frozen=True)
class Run:
    """One run of a scene.

    Attributes
    ----------
    case : dict
        A case as in its TOML file; of bodies from Python, what `tools.extreme.hostile_python` makes them of.
    threads : int
        Number of threads.
    is_python : bool
        Whether bodies are made from Python.
    """

    case: Case
    threads: int = 1
    is_python: bool = False


@dataclass(frozen=True)
class Scene:
    """A scene and, perhaps, another one whose numbers must be the same.

    Attributes
    ----------
    label, what : str
        Its key, and what was drawn, in words.
    run : Run
        The scene.
    relation : str
        How the other run is related: "mirrored", "scaled", "threads", "levels", "far body" or nothing.
    other : Run, optional
        The other run.
    factors : tuple of float
        Units of length and stress of the other run, as multiples of those of the scene.
    is_slope : bool
        Whether levels are so near each other that the slope of the energy is the force.
    """

    label: str
    what: str
    run: Run
    relation: str = ""
    other: Run | None = None
    factors: tuple[float, float] = field(default=(1.0, 1.0))
    is_slope: bool = False


def _number(draw: Draw, low: float, high: float) -> float:
    return float(f"{draw.uniform(low, high):.3g}")


def _one(draw: Draw, *choices: Any) -> Any:
    return choices[int(draw.integers(len(choices)))]


def _material(draw: Draw, modulus: float = 2.0) -> Case:
    share, bulk = _number(draw, 0.0, 0.8), _one(draw, 5.0, 25.0, 50.0, 200.0)
    constants = {"c1": modulus * (1 - share), "c2": modulus * share, "bulk_modulus": modulus * bulk}
    return {"kind": "mooney-rivlin", **constants}


def _tissue(draw: Draw) -> Case:
    tissue: Case = {"rows": _one(draw, 1, 1, 2, 2, 3), "cols": _one(draw, 1, 2, 3), "wall": _number(draw, 0.04, 0.4)}
    if tissue["rows"] * tissue["cols"] > 6:
        tissue["cols"] = 2
    tissue["orientation"] = _one(draw, "pointy", "pointy", "flat")
    if draw.random() < 0.3:
        largest = min(sqrt(3) / 2, tissue["wall"] / (1 - sqrt(3) / 2))
        tissue["corner_radius"] = _number(draw, 0.05, 0.9) * round(largest, 3)
    return tissue


def _height(tissue: Case) -> float:
    rows, cols = tissue["rows"], tissue["cols"]
    if tissue["orientation"] == "pointy":
        return 1.5 * int(rows) + 0.5
    return sqrt(3) * (int(rows) + (0.5 if cols > 1 else 0))


def _case(draw: Draw, move: tuple[float, float], levels: Any, **more: Any) -> Case:
    """Return cells between plates that move by this share of their distance."""
    tissue = _tissue(draw)
    move = tuple(round(share * _height(tissue), 3) for share in move)  # type: ignore[assignment]
    case: Case = {
        "tissue": tissue,
        "material": _material(draw),
        "load": {"kind": "plates", "displacement": list(move), "levels": levels},
        "strategy": {"kind": _one(draw, "sddp", "sddp", "single-step")},
        "contact": {"kind": "mortar" if draw.random() < 0.15 else "penalty"},
        "mesh": {"order": _one(draw, 2, 3, 3)},
        "accuracy": inf,
    }
    return case | more


def _shear(draw: Draw) -> Case:
    return _case(draw, (_number(draw, -0.6, 0.6), _number(draw, -0.1, 0.15)), _one(draw, 1, 2, 3))


def _compression(draw: Draw) -> Case:
    return _case(draw, (_number(draw, -0.2, 0.2), _number(draw, -0.75, -0.2)), _one(draw, 1, 2, 3))


def _frame(draw: Draw) -> Case:
    case = _case(draw, (0.0, 0.0), _one(draw, 1, 2))
    motion: Case = _one(
        draw,
        {"shear": _number(draw, -0.5, 0.5)},
        {"stretch": [_number(draw, 0.75, 1.3), _number(draw, 0.75, 1.3)]},
        {"deformation_gradient": [[_number(draw, 0.8, 1.2), _number(draw, -0.3, 0.3)], [0.0, _number(draw, 0.8, 1.2)]]},
    )
    return case | {"load": {"kind": "frame", "levels": case["load"]["levels"], **motion}}


def _pressure(draw: Draw) -> Case:
    case = _case(draw, (_number(draw, -0.3, 0.3), _number(draw, -0.1, 0.1)), _one(draw, 1, 2))
    tissue = case["tissue"]
    cells = draw.uniform(0, 0.03, (tissue["rows"], tissue["cols"])).round(4).tolist()
    pressure = _one(draw, cells[0][0], cells[-1][-1], cells)
    return case | {"lumen": {"kind": "pressure", "pressure": pressure, "ramp": _one(draw, "with-load", "first")}}


def _fluid(draw: Draw) -> Case:
    case = _case(draw, (_number(draw, -0.3, 0.3), _number(draw, -0.15, 0.1)), _one(draw, 1, 2))
    fill = _one(draw, 1.0, _number(draw, 0.75, 0.97), _number(draw, 1.03, 1.2))
    return case | {"lumen": {"kind": "fluid", "fill": fill, "ramp": _one(draw, "with-load", "first")}}


def _cycle(draw: Draw) -> Case:
    levels = _one(draw, [0.5, 1.0, 0.5, 0.0], [1.0, 0.0, 1.0], [0.4, 0.8, 0.2, 1.0], [1.0, 0.5])
    return _case(draw, (_number(draw, -0.4, 0.4), _number(draw, -0.1, 0.1)), levels)


def _steady(draw: Draw) -> Case:
    return _case(draw, (_number(draw, -0.3, 0.3), _number(draw, -0.25, 0.2)), [0.49, 0.5, 0.51, 0.99, 1.0])


def _block(name: str, low: list[float], high: list[float], draw: Draw, size: float) -> Case:
    return {"name": name, "kind": "block", "low": low, "high": high, "size": size, "material": _material(draw, 1.0)}


def _punch(draw: Draw) -> Case:
    """A block above a clamped bar, which is pressed down or dropped through it."""
    width, height, gap = _number(draw, 0.3, 1.2), _number(draw, 0.1, 0.5), _one(draw, 0.0, 0.05, 0.1)
    left, down = _number(draw, 0.3, 1.2), _number(draw, 0.1, 1.2)
    bar, punch = _block("bar", [0.0, 0.0], [2.5, height], draw, height), _block(
        "punch", [left, height + gap], [left + width, height + gap + 0.6], draw, width / 2)  # fmt: skip
    return {
        "levels": _one(draw, 1, 2, 4),
        "bodies": [bar, punch],
        "supports": [{"boundary": "bar_left"}, {"boundary": "bar_right"},
                     {"boundary": "punch_top", "translation": [0.0, -round(down + gap, 3)]}],
        "contact": {"kind": "penalty"},
        "mesh": {"order": _one(draw, 1, 2, 3)},
        "accuracy": inf,
    }  # fmt: skip


def _stack(draw: Draw) -> Case:
    """A block on a block, pressed together and sheared."""
    offset, width = _number(draw, -0.3, 0.3), _number(draw, 0.3, 1.3)
    return {
        "levels": _one(draw, 1, 2),
        "bodies": [_block("base", [0.0, 0.0], [1.0, 1.0], draw, _number(draw, 0.2, 0.6)),
                   _block("top", [offset, 1.0], [offset + width, 1.0 + width], draw, _number(draw, 0.2, 0.6) * width)],
        "supports": [{"boundary": "base_bottom"},
                     {"boundary": "top_top", "translation": [_number(draw, -0.2, 0.2), _number(draw, -0.3, -0.02)]}],
        "contact": {"kind": _one(draw, "penalty", "mortar")},
        "mesh": {"order": _one(draw, 1, 2, 3)},
        "accuracy": inf,
    }  # fmt: skip


def _rings(draw: Draw) -> Case:
    """A ring in a ring that is too narrow or too wide, under pressure or suction."""
    bore, pressure = _number(draw, 0.85, 1.05), _one(draw, 0.0, _number(draw, 0.01, 0.1), _number(draw, -0.06, -0.01))
    bulk = _one(draw, 10.0, 100.0, 1000.0)
    material = {"kind": "mooney-rivlin", "c1": 0.6, "c2": 0.4, "bulk_modulus": bulk}
    part = {"kind": "ring", "part": "upper-right", "material": material}
    ring = part | {"name": "ring", "inner": _number(draw, 0.3, 0.7), "outer": 1.0, "size": 0.3, "walls": ["outer"]}
    hub = part | {"name": "hub", "inner": bore, "outer": _number(draw, 1.3, 2.0), "size": 0.35, "walls": ["inner"]}
    return {
        "levels": _one(draw, 1, 2, [0.5, 1.0, 0.0]),
        "bodies": [ring, hub],
        "supports": [{"boundary": f"{name}_{axis}0", "components": axis} for name in ("ring", "hub") for axis in "xy"],
        "loads": [{"kind": "pressure", "boundary": "ring_inner", "value": pressure}] if pressure else [],
        "contact": {"kind": _one(draw, "penalty", "mortar")},
        "mesh": {"order": _one(draw, 2, 3)},
        "accuracy": inf,
    }


def _polygons(draw: Draw) -> Case:
    """Polygons from Python: a wedge or a bar on a bar that is held at its ends or below."""
    half, depth = _number(draw, 0.2, 0.6), _number(draw, 0.05, 0.4)
    tip = _one(draw, 0.0, 0.1, half)
    upper = [[1 - half, 1.1], [1 - tip, 0.5], [1 + tip, 0.5], [1 + half, 1.1]] if tip else [
        [1 - half, 1.1], [1.0, 0.5], [1 + half, 1.1]]  # fmt: skip
    return {
        "order": _one(draw, 1, 2, 3),
        "size": _number(draw, 0.2, 0.5),
        "levels": _one(draw, 1, 3),
        "bodies": [{"name": "bar", "corners": [[0, 0], [2, 0], [2, 0.5], [0, 0.5]], "material": _material(draw, 1.0)},
                   {"name": "upper", "corners": upper, "material": _material(draw, 1.0)}],
        "held": [{"body": "bar", "y": 0.0, "move": [0.0, 0.0]}, {"body": "upper", "y": 1.1, "move": [0.0, -depth]}],
    }  # fmt: skip


#: What is drawn, how often, and which relations to another run are tried in turn.
FAMILIES: tuple[tuple[str, int, Callable[[Draw], Case], tuple[str, ...]], ...] = (
    ("shear", 34, _shear, ("", "scaled", "", "threads", "mirrored")),
    ("compression", 22, _compression, ("", "threads", "", "mirrored", "scaled")),
    ("frame", 16, _frame, ("", "scaled", "threads")),
    ("pressure", 14, _pressure, ("", "scaled")),
    ("fluid", 14, _fluid, ("", "scaled", "threads")),
    ("cycle", 12, _cycle, ("",)),
    ("slope", 10, _steady, ("",)),
    ("punch", 10, _punch, ("levels", "mirrored")),
    ("stack", 6, _stack, ("far body", "mirrored", "scaled")),
    ("rings", 6, _rings, ("", "scaled")),
    ("python", 6, _polygons, ("", "mirrored", "levels")),
)


def scenes(seed: int = SEED) -> list[Scene]:
    """Return all scenes: one of each family in turn, so that the first ones are of all kinds."""
    rounds = max(count for _, count, *_ in FAMILIES)
    return [
        _scene(seed, family, number)
        for number in range(rounds)
        for family, entry in enumerate(FAMILIES)
        if number < entry[1]
    ]


def _scene(seed: int, family: int, number: int) -> Scene:
    name, _, drawn, relations = FAMILIES[family]
    draw = np.random.default_rng((seed, family, number))
    case = drawn(draw)
    run = Run(case, is_python=name == "python")
    relation = relations[number % len(relations)]
    other = _related(case, relation, run)
    factors = (_LENGTH, _STRESS) if relation == "scaled" else (1.0, 1.0)
    return Scene(f"{name} {number:02}", _words(case), run, relation if other else "", other, factors, name == "slope")


_LENGTH, _STRESS = 1e-3, 1e4


def _related(case: Case, relation: str, run: Run) -> Run | None:
    if relation == "threads":
        return Run(case, 2)
    changed = {"mirrored": _mirrored, "scaled": _scaled, "levels": _in_more_levels, "far body": _with_far_body}
    other = changed[relation](deepcopy(case)) if relation else None
    return None if other is None else Run(other, is_python=run.is_python)


def _mirrored(case: Case) -> Case | None:
    """Return the mirror image in x; None where its lattice is another one."""
    if "tissue" in case:
        tissue = case["tissue"]
        is_same = tissue["rows"] == 1 if tissue["orientation"] == "pointy" else tissue["cols"] % 2
        case["load"]["displacement"][0] *= -1
        return case if is_same and "lumen" not in case else None
    for body in case["bodies"]:
        if "corners" in body:
            body["corners"] = [[-x, y] for x, y in reversed(body["corners"])]
        else:
            body["low"][0], body["high"][0] = -body["high"][0], -body["low"][0]
    for support in case.get("supports", ()):
        side = support["boundary"]
        support["boundary"] = side.replace("left", "right") if "left" in side else side.replace("right", "left")
        if "translation" in support:
            support["translation"][0] *= -1
    return case


def _scaled(case: Case) -> Case:
    """Return the case in other units of length and stress."""
    for owner in [case, *case.get("bodies", ())]:
        for key in owner.keys() & {"material"}:
            owner[key] = {name: value * _STRESS if name != "kind" else value for name, value in owner[key].items()}
    if "tissue" in case:
        for key in ("wall", "corner_radius"):
            if key in case["tissue"]:
                case["tissue"][key] *= _LENGTH
        case["tissue"]["side"] = _LENGTH
        if "displacement" in case["load"]:
            case["load"]["displacement"] = [part * _LENGTH for part in case["load"]["displacement"]]
        lumen = case.get("lumen", {})
        if "pressure" in lumen:
            lumen["pressure"] = _times(lumen["pressure"], _STRESS)
        return case
    for body in case["bodies"]:
        for key in body.keys() & {"low", "high", "size", "inner", "outer"}:
            body[key] = _times(body[key], _LENGTH)
    for support in case["supports"]:
        if "translation" in support:
            support["translation"] = _times(support["translation"], _LENGTH)
    for load in case.get("loads", ()):
        load["value"] *= _STRESS
    return case


def _times(value: Any, factor: float) -> Any:
    return [_times(part, factor) for part in value] if isinstance(value, list) else value * factor


def _in_more_levels(case: Case) -> Case:
    return case | {"levels": 10}


def _with_far_body(case: Case) -> Case:
    """Return the case with a body far away that is held and touches nothing."""
    far = {"name": "far", "kind": "block", "low": [40.0, 40.0], "high": [41.0, 41.0], "size": 0.5,
           "material": deepcopy(case["bodies"][0]["material"])}  # fmt: skip
    case["bodies"].append(far)
    case["supports"].append({"boundary": "far_bottom"})
    return case


def _words(case: Case) -> str:
    """Return what was drawn, in a line."""
    if "tissue" not in case:
        bodies = " and ".join(body["name"] for body in case["bodies"])
        return f"{bodies}, levels {case['levels']}, order {case.get('order') or case['mesh']['order']}"
    tissue, load = case["tissue"], {key: value for key, value in case["load"].items() if key != "kind"}
    shape = f"{tissue['rows']}x{tissue['cols']} {tissue['orientation']}, wall {tissue['wall']}"
    radius = f", radius {tissue['corner_radius']:.3g}" if "corner_radius" in tissue else ""
    moved = ", ".join(f"{key} {value}" for key, value in load.items())
    lumen = "".join(f", {key} {value}" for key, value in case.get("lumen", {}).items() if key != "kind")
    ratio = case["material"]["bulk_modulus"] / (case["material"]["c1"] + case["material"]["c2"])
    how = f"{case['strategy']['kind']}, {case['contact']['kind']}, order {case['mesh']['order']}"
    return f"{shape}{radius}, {moved}{lumen}, kappa/mu {ratio:.3g}, {how}"
