"""GetFEM on bodies that are grids; run by a Python that has the module `getfem`, with a file that tells the problem.

Quadratic or linear displacements on curved quadrilaterals, its compressible Mooney-Rivlin in plane strain, whose
volumetric part is ``d1 (J - 1)^2``, and its large-sliding contact by ray tracing with an augmented Lagrangian, one for
each pair of walls. Prints a JSON object: force and opening, or why there are none.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import getfem as gf
import numpy as np

#: How far from a wall another one is searched.
REACH = 0.3


class Body:
    """A body: its mesh of second degree, and its displacements.

    Regions of the mesh are numbered: one for each side, and one for the sides of each support.
    """

    def __init__(self, name: str, given: dict[str, Any], order: int) -> None:
        self.places, self.variable = np.array(given["places"]), f"u_{name}"
        self.nodes = {side: set(nodes) for side, nodes in given["sides"].items()}
        self.order, self.start = order, np.array(given["start"])
        self.mesh, shape = gf.Mesh("empty", 2), gf.GeoTrans("GT_QK(2,2)")
        for nodes in np.array(given["elements"]):
            self.mesh.add_convex(shape, self.places[nodes.T.ravel()].T)
        self._number = {tuple(np.round(place, 9)): node for node, place in enumerate(self.places)}
        self._faces = [(face, self.at(self._places(face))) for face in self.mesh.outer_faces().T]
        self._regions: dict[tuple[str, ...], int] = {}
        self.rule = gf.MeshIm(self.mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(2,6)"))
        self.fem = self.functions(2)

    def functions(self, components: int) -> Any:
        """Return functions of the order of the displacements."""
        fem = gf.MeshFem(self.mesh, components)
        fem.set_fem(gf.Fem(f"FEM_QK(2,{self.order})"))
        return fem

    def _places(self, face: Any) -> Any:
        return self.mesh.pts(self.mesh.pid_in_faces(face[:, None])).T

    def at(self, places: Any) -> list[int]:
        """Return the nodes at these places."""
        return [self._number[tuple(np.round(place, 9))] for place in places]

    def region(self, sides: list[str]) -> int:
        """Return the number of the region of these sides."""
        key = tuple(sides)
        if key not in self._regions:
            self._regions[key] = len(self._regions) + 1
            on = [face for face, nodes in self._faces if any(self.nodes[side].issuperset(nodes) for side in sides)]
            self.mesh.set_region(self._regions[key], np.array(on).T)
        return self._regions[key]

    def start_values(self) -> Any:
        """Return the displacements that are given to start from, one for each unknown."""
        nodes = self.fem.basic_dof_nodes()
        return self.start[self.at(nodes.T), np.arange(nodes.shape[1]) % 2]


def solved(given: dict[str, Any]) -> dict[str, Any]:
    """Return force, opening and the number of unknowns."""
    model = gf.Model("real")
    bodies = {name: Body(name, body, given["order"]) for name, body in given["bodies"].items()}
    model.add_initialized_data("law", given["law"])
    model.add_initialized_data("r", [given["modulus"]])
    model.add_initialized_data("load", [0.0])
    for body in bodies.values():
        model.add_fem_variable(body.variable, body.fem)
        model.add_finite_strain_elasticity_brick(body.rule, "Compressible Mooney Rivlin", body.variable, "law")
    for number, pair in enumerate(given["pairs"]):
        touch(model, f"pressure{number}", bodies, pair)
    for number, support in enumerate(given["supports"]):
        hold(model, f"hold{number}", bodies[support["body"]], support)
    for body in bodies.values():
        if len(body.start):
            model.set_variable(body.variable, body.start_values())
    for load in np.linspace(0, 1, given["steps"] + 1)[1:]:
        model.set_variable("load", [load])
        newton(model)
    force = sum(borne(model, f"hold{n}", bodies[one["body"]], one) for n, one in enumerate(given["supports"]))
    return {"force": force, "opening": parted(model, bodies, given), "unknowns": model.nbdof()}


def touch(model: Any, name: str, bodies: dict[str, Body], pair: dict[str, Any]) -> None:
    """Let two walls press on each other."""
    (first, side), (second, other) = pair["first"], pair["second"]
    slave, master = bodies[first], bodies[second]
    region = slave.region([side])
    model.add_filtered_fem_variable(name, slave.functions(2), region)
    brick = model.add_integral_large_sliding_contact_brick_raytracing("r", REACH)
    model.add_slave_contact_boundary_to_large_sliding_contact_brick(brick, slave.rule, region, slave.variable, name)
    model.add_master_contact_boundary_to_large_sliding_contact_brick(
        brick, master.rule, master.region([other]), master.variable
    )


def hold(model: Any, name: str, body: Body, support: dict[str, Any]) -> None:
    """Prescribe displacements by multipliers, whose integrals are the forces."""
    region = body.region(support["sides"])
    for axis in support["axes"]:
        (a, b), c = support["gradient"][axis], support["translation"][axis]
        what, of = f"{name}_{axis}", f"{body.variable}({axis + 1})"
        model.add_filtered_fem_variable(what, body.functions(1), region)
        moved = f"load*({a!r}*X(1) + {b!r}*X(2) + {c!r})"
        model.add_linear_term(body.rule, f"({of} - {moved})*Test_{what} + {what}*Test_{of}", region)


def borne(model: Any, name: str, body: Body, support: dict[str, Any]) -> float:
    """Return what a support counts in the force that is compared; its multiplier is the force of the body on it."""
    region, shares = body.region(support["sides"]), support["shares"]
    axes = [axis for axis in support["axes"] if shares[axis]]
    forces = [float(gf.asm_generic(body.rule, 0, f"{name}_{axis}", region, model)) for axis in axes]
    return -sum((shares[axis] * force for axis, force in zip(axes, forces, strict=True)), 0.0)


def parted(model: Any, bodies: dict[str, Body], given: dict[str, Any]) -> float | None:
    """Return how far the middles of two walls have parted along the normal at rest."""
    if given["opening"] is None:
        return None
    moved = []
    for which in ("first", "second"):
        name, side = given["opening"][which]
        body, nodes = bodies[name], given["bodies"][name]["sides"][side]
        place, values = body.places[nodes[len(nodes) // 2]], model.variable(body.variable)
        near = np.linalg.norm(body.fem.basic_dof_nodes().T - place, axis=1) < 1e-9
        moved.append(values[np.flatnonzero(near)])
    return float((moved[1] - moved[0]) @ np.array(given["normal"]))


def newton(model: Any) -> None:
    """Solve."""
    _, converged = model.solve("max_res", 1e-9, "max_iter", 60)
    if not converged:
        raise RuntimeError("no convergence")


def main(file: str) -> None:
    """Solve what a file says, and print the answer."""
    gf.util_trace_level(0)
    try:
        answer = solved(json.loads(Path(file).read_text()))
    except Exception as error:
        answer = {"error": (str(error).strip().splitlines() or [type(error).__name__])[-1][:80]}
    sys.stdout.write("ANSWER " + json.dumps(answer) + "\n")
