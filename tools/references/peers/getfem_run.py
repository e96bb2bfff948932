"""GetFEM on blocks or rings; run by a Python that has the module `getfem`, with a file of grids and numbers.

Quadratic or linear displacements on curved quadrilaterals, its compressible Mooney-Rivlin in plane strain, whose
volumetric part is ``d1 (J - 1)^2``, and its large-sliding contact by ray tracing with an augmented Lagrangian. Prints a
JSON object: the force, or why there is none.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import getfem as gf
import numpy as np

FIRST, LAST, LOW, HIGH = 1, 2, 3, 4


def grid_mesh(places: Any) -> Any:
    """Return a mesh of quadrilaterals of second degree through these places, with its four sides as regions."""
    width, height = places.shape[:2]
    mesh, shape = gf.Mesh("empty", 2), gf.GeoTrans("GT_QK(2,2)")
    for i in range(0, width - 1, 2):
        for j in range(0, height - 1, 2):
            mesh.add_convex(shape, np.array([places[i + a, j + b] for b in range(3) for a in range(3)]).T)
    points = places.reshape(-1, 2)
    number = {tuple(np.round(point, 9)): index for index, point in enumerate(points)}
    sides: dict[int, list[tuple[int, int]]] = {FIRST: [], LAST: [], LOW: [], HIGH: []}
    for convex, face in mesh.outer_faces().T:
        on = mesh.pts(mesh.pid_in_faces(np.array([[convex], [face]]))).T
        index = np.array([number[tuple(np.round(point, 9))] for point in on])
        i, j = index // height, index % height
        for side, hit in ((FIRST, i == 0), (LAST, i == width - 1), (LOW, j == 0), (HIGH, j == height - 1)):
            if hit.all():
                sides[side].append((convex, face))
    for side, faces in sides.items():
        mesh.set_region(side, np.array(faces).T)
    return mesh


def solved(given: dict[str, Any]) -> tuple[float, int]:
    """Return the force and the number of unknowns."""
    grids = [np.array(places) for places in given["grids"]]
    meshes = [grid_mesh(places) for places in grids]
    order, is_blocks = given["order"], given["problem"] == "blocks"
    model, fems, rules = gf.Model("real"), [], []
    c1, c2, kappa = given["c1"], given["c2"], given["kappa"]
    model.add_initialized_data("law", [c1 / 2, c2 / 2, kappa / 2])
    model.add_initialized_data("r", [given["modulus"]])
    for number, mesh in enumerate(meshes, 1):
        fem, rule = gf.MeshFem(mesh, 2), gf.MeshIm(mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(2,6)"))
        fem.set_fem(gf.Fem(f"FEM_QK(2,{order})"))
        model.add_fem_variable(f"u{number}", fem)
        model.add_finite_strain_elasticity_brick(rule, "Compressible Mooney Rivlin", f"u{number}", "law")
        fems.append(fem)
        rules.append(rule)
    slave, master = (HIGH, LOW) if is_blocks else (LAST, FIRST)
    multiplier = gf.MeshFem(meshes[0], 2)
    multiplier.set_fem(gf.Fem(f"FEM_QK(2,{order})"))
    model.add_filtered_fem_variable("pressure", multiplier, slave)
    brick = model.add_integral_large_sliding_contact_brick_raytracing("r", 0.3)
    model.add_slave_contact_boundary_to_large_sliding_contact_brick(brick, rules[0], slave, "u1", "pressure")
    model.add_master_contact_boundary_to_large_sliding_contact_brick(brick, rules[1], master, "u2")
    hold(model, meshes, rules, order, is_blocks)
    if is_blocks:
        model.add_initialized_data("down", [0.0])
        model.add_filtered_fem_variable("hold", scalar(meshes[1], order), HIGH)
        model.add_linear_term(rules[1], "(u2(2) - down)*Test_hold + hold*Test_u2(2)", HIGH)
        for share in np.linspace(0.25, 1, 4):
            model.set_variable("down", [share * 2 * (given["pressed"] - 1)])
            newton(model)
        return abs(float(gf.asm_generic(rules[1], 0, "hold", HIGH, model))), model.nbdof()
    start_press_fit(model, fems, grids)
    newton(model)
    sides = (("hold2x", HIGH), ("hold2y", LOW))
    bears = [abs(float(gf.asm_generic(rules[1], 0, name, side, model))) for name, side in sides]
    return sum(bears) / 2, model.nbdof()


def scalar(mesh: Any, order: int) -> Any:
    """Return scalar functions of this order."""
    fem = gf.MeshFem(mesh, 1)
    fem.set_fem(gf.Fem(f"FEM_QK(2,{order})"))
    return fem


def hold(model: Any, meshes: list[Any], rules: list[Any], order: int, is_blocks: bool) -> None:
    """Hold sides by multipliers, whose integrals are the forces."""
    for number, (mesh, rule) in enumerate(zip(meshes, rules, strict=True), 1):
        sides = [(FIRST, 1, "f"), (LAST, 1, "l")] if is_blocks else [(LOW, 2, "y"), (HIGH, 1, "x")]
        sides += [(LOW, 2, "b")] if is_blocks and number == 1 else []
        for side, axis, ending in sides:
            name = f"hold{number}{ending}"
            model.add_filtered_fem_variable(name, scalar(mesh, order), side)
            model.add_linear_term(rule, f"u{number}({axis})*Test_{name} + {name}*Test_u{number}({axis})", side)


def start_press_fit(model: Any, fems: list[Any], grids: list[Any]) -> None:
    """Start where rings of constant area would touch half-way between rim and bore."""
    rim, bore = (np.linalg.norm(grids[0][-1, 0]), np.linalg.norm(grids[1][0, 0]))
    middle = (rim + bore) / 2
    for name, fem, radius in (("u1", fems[0], rim), ("u2", fems[1], bore)):
        nodes = fem.basic_dof_nodes()
        size = np.linalg.norm(nodes, axis=0)
        scale = np.sqrt(size**2 + middle**2 - radius**2) / size - 1
        values = scale * nodes
        axis = np.arange(nodes.shape[1]) % 2
        model.set_variable(name, values[axis, np.arange(nodes.shape[1])])


def newton(model: Any) -> None:
    """Solve."""
    _, converged = model.solve("max_res", 1e-9, "max_iter", 60)
    if not converged:
        raise RuntimeError("no convergence")


def main(file: str) -> None:
    """Solve what a file says, and print the answer."""
    gf.util_trace_level(0)
    try:
        force, unknowns = solved(json.loads(Path(file).read_text()))
        answer: dict[str, Any] = {"force": force, "unknowns": unknowns}
    except Exception as error:
        answer = {"error": (str(error).strip().splitlines() or [type(error).__name__])[-1][:80]}
    sys.stdout.write("ANSWER " + json.dumps(answer) + "\n")
