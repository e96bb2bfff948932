"""Stiff points, perturbed: how far does the answer move?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from tools.extreme.point import Point
from tools.extreme.scenes import MORTAR, PENALTY, Case, tissue


def perturbations(point: Point) -> Iterator[Point]:
    """Yield the point with a finer mesh, with three times the steps, a stiffer penalty, and less exactly solved."""
    changes = {"mesh": _finer, "steps": _with_more_steps, "penalty": _with_stiffer_penalty}
    for name, change in changes.items():
        if name == "penalty" and _has_mortar(point):
            continue
        case = partial(change, point)
        yield replace(point, setting=f"{point.setting}; {name}", build=case, perturbed_from=point.label, is_quick=False)
    yield replace(
        point, setting=f"{point.setting}; tolerance", perturbed_from=point.label, tolerance=1e4, is_quick=False
    )


def _has_mortar(point: Point) -> bool:
    """Return whether a point has mortar contact, without building its case."""
    default = PENALTY if point.build.func is tissue else MORTAR
    return bool(point.build.keywords.get("contact", default)["kind"] == "mortar")


def _finer(point: Point) -> Case:
    """A mesh with elements three quarters as long."""
    case = point.case
    mesh = dict(case.get("mesh", {}))
    if "tissue" in case:
        side = case["tissue"].get("side", 1.0)
        return case | {"mesh": mesh | {"size": 0.75 * mesh.get("size", side / 2)}}
    if "refine" in mesh:
        mesh["refine"] = [zone | {"size": 0.75 * zone["size"]} for zone in mesh["refine"]]
    return case | {"mesh": mesh, "bodies": [body | {"size": 0.75 * body["size"]} for body in case["bodies"]]}


def _with_more_steps(point: Point) -> Case:
    case = point.case
    if "tissue" in case:
        levels = case["load"]["levels"]
        strategy = {"kind": "sddp"} | case.get("strategy", {})
        return case | {"strategy": strategy | {"steps": 3 * (levels if isinstance(levels, int) else len(levels))}}
    return case | {"steps": 3 * case["levels"]}


def _with_stiffer_penalty(point: Point) -> Case:
    contact = point.case["contact"]
    return point.case | {"contact": contact | {"stiffness": 3 * contact.get("stiffness", 1.0)}}
