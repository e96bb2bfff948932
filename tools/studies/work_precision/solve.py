"""One run in this process: solve a setting and return what is compared, and what it took."""

from __future__ import annotations

import json
from math import inf
from time import perf_counter, process_time
from typing import Any

import ngcell
from ngcell import Mortar, Penalty
from tools.solutions import Solution
from tools.solutions import solved as solve_scene
from tools.studies.work_precision import rings
from tools.studies.work_precision.grid import Setting


def solved(setting: Setting) -> dict[str, Any]:
    """Solve, and return errors or quantities, unknowns, iterations and seconds by phase."""
    started = perf_counter(), process_time()
    solution = solve_scene(scene_of(setting))
    taken = perf_counter() - started[0], process_time() - started[1]
    phases = solution.seconds
    return {
        **_compared(setting, solution),
        "unknowns": solution.unknowns,
        "iterations": solution.iterations,
        "factorisations": solution.factorisations,
        "wall_seconds": round(taken[0], 3),
        "seconds": round(taken[1] - phases["measuring"], 3),
        "phases": json.dumps({name: round(value, 3) for name, value in phases.items()}),
        "certified": solution.certified,
    }


def _contact(method: str) -> Any:
    return Mortar() if method == "mortar" else Penalty(stiffness=float(method.partition(" x")[2] or 1))


def scene_of(setting: Setting, accuracy: float = inf) -> Any:
    """Return the scene of a setting, which asks for no accuracy if none is given."""
    if setting.kind == "rings":
        return rings.scene(setting.problem, _contact(setting.method), setting.order, setting.size, accuracy)
    method, _, stiffness = setting.method.partition(" x")
    sets = [f"contact.kind={method}", f"mesh.order={setting.order}", f"accuracy={accuracy}"]
    sets += [f"contact.stiffness={stiffness}"] if stiffness else []
    if setting.kind == "tissue":
        sets += [f"mesh.size={setting.size}", f"strategy.kind={setting.strategy}", f"load.levels={setting.steps}"]
        return ngcell.read_case(setting.case, sets + list(setting.overrides))
    return _refined(ngcell.read_case(setting.case, sets), setting.size)


def _refined(case: Any, factor: float) -> Any:
    """Return a case of user-defined bodies with all sizes of elements multiplied by a factor."""
    zones = tuple(zone.model_copy(update={"size": zone.size * factor}) for zone in case.mesh.refine)
    size = case.mesh.size and case.mesh.size * factor
    mesh = case.mesh.model_copy(update={"refine": zones, "size": size})
    bodies = tuple(body.model_copy(update={"size": body.size and body.size * factor}) for body in case.bodies)
    return case.model_copy(update={"mesh": mesh, "bodies": bodies})


def _compared(setting: Setting, solution: Solution) -> dict[str, Any]:
    """Return relative errors where an exact answer exists, else the quantities themselves."""
    if setting.kind == "rings":
        found = rings.errors(setting.problem, solution)
        return {f"error_{name}": value for name, value in found.items()}
    if setting.kind == "case":
        found = {finding.quantity: abs(finding.deviation) for finding in solution.last.findings}
        names = {
            "error_gap": ("nominal_contact_width", "mean_radius"),
            "error_pressure": ("nominal_peak_pressure", "contact_pressure"),
            "error_force": ("force_y",),
        }
        return {
            column: max(found[name] for name in wanted if name in found)
            for column, wanted in names.items()
            if any(name in found for name in wanted)
        }
    record = solution.last.record
    return {
        "gap": record.mean_gap,
        "pressure": record.contact_force,
        "force": (record.plate_force_x**2 + record.plate_force_y**2) ** 0.5,
        "energy": record.energy,
        "parted": record.parted_pairs,
    }
