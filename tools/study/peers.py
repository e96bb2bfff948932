"""Other programs on the rings: the same meshes, laws, supports and loads, an error and a time.

naive
    NGSolve as its tutorial on contact has it: `ContactBoundary` with a penalty on one side, the loads in ten steps, and
    Newton's method with halved steps.
calculix
    CalculiX (`ccx`), if it is installed: linear wedges of one layer that are held across (the deck for quadratic ones,
    C3D15, is written, too, but CalculiX 2.20 refuses its elements), its Mooney-Rivlin law, whose volumetric part is
    ``kappa/2 (J - 1)^2``, and a linear penalty from surface to surface. Its seconds are those on the clock.

Stiffnesses are those of this package's default penalty, about ten times a layer of elements.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from tools.study import rings
from tools.study.grid import Setting

PROBLEMS = ("press-fit", "above")
#: Load steps of the naive script, iterations of each, and halvings of a Newton step.
STEPS, ITERATIONS, HALVINGS = 40, 60, 12
THICKNESS = 0.05


def settings(quick: bool) -> Iterator[Setting]:
    """Yield what the others are asked to solve."""
    for size, problem in product((0.25, 0.125) if quick else (0.25, 0.125, 0.0625), PROBLEMS):
        for order in (2, 3):
            yield Setting("naive", problem, "naive", order, size)
        yield Setting("calculix", problem, "calculix", 1, size)


def missing() -> list[str]:
    """Return what is not installed here, in words."""
    lines = [] if shutil.which("ccx") else ["CalculiX: no program `ccx` (Debian: calculix-ccx); its lines are left out"]
    return [*lines, "GetFEM: no script for these scenes; its line is left out"]


def available(setting: Setting) -> bool:
    """Return whether a peer can run here."""
    return setting.kind != "calculix" or shutil.which("ccx") is not None


def _mesh(setting: Setting) -> Any:
    from ngcell.build.discretisation import draw_up

    from ngcell.scene import Penalty

    discretisation = draw_up(rings.scene(setting.problem, Penalty(), setting.order, setting.size))
    modulus = min(law.plane_strain_modulus for law in discretisation.laws)
    return discretisation, 10 * modulus / (rings.MISMATCH * setting.size * 3**0.5 / 4)


def naive(setting: Setting) -> dict[str, Any]:
    """Solve with NGSolve's contact boundary."""
    import ngsolve as ngs
    import numpy as np

    ngs.SetNumThreads(1)
    started = process_time()
    discretisation, stiffness = _mesh(setting)
    mesh, law = discretisation.bodies.mesh, discretisation.laws[0]
    space = ngs.VectorH1(mesh, order=setting.order, dirichletx="inner-y|outer-y", dirichlety="inner-x|outer-x")
    trial, test = space.TnT()
    gradient = ngs.Id(2) + ngs.Grad(trial)
    share = ngs.Parameter(0.0)
    form = ngs.BilinearForm(space)
    form += ngs.Variation(law.stored_energy(gradient).Compile() * ngs.dx)
    pressure = rings.PROBLEMS[setting.problem][3]
    if pressure is not None:
        along, normal = ngs.Grad(trial).Trace(), ngs.specialcf.normal(2)
        turned = ngs.CF(
            (
                normal[0] + along[1, 1] * normal[0] - along[1, 0] * normal[1],
                normal[1] + along[0, 0] * normal[1] - along[0, 1] * normal[0],
            )
        )
        form += share * pressure * (turned * test) * ngs.ds("inner-bore")
    contact = ngs.ContactBoundary(mesh.Boundaries("inner-rim"), mesh.Boundaries("outer-bore"))
    place = ngs.CF((ngs.x, ngs.y))
    overlap = (place + trial - place.Other() - trial.Other()) * contact.normal
    contact.AddEnergy(ngs.IfPos(overlap, stiffness / 2 * overlap * overlap, 0))
    field, iterations = ngs.GridFunction(space), 0
    residual, step, old = (field.vec.CreateVector() for _ in range(3))
    free = np.array(list(space.FreeDofs()))

    def missed() -> float:
        form.Apply(field.vec, residual)
        return float(np.linalg.norm(residual.FV().NumPy()[free]))

    steps = STEPS if pressure is not None else 1
    for number in range(steps):
        share.Set((number + 1) / steps)
        for _ in range(ITERATIONS):
            contact.Update(field, form, intorder=2 * setting.order, maxdist=0.3)
            before = missed()
            if before < 1e-10:
                break
            form.AssembleLinearization(field.vec)
            step.data = form.mat.Inverse(space.FreeDofs(), inverse="umfpack") * residual
            iterations += 1
            old.data, length = field.vec, 1.0
            for _ in range(HALVINGS):
                field.vec.data = old - length * step
                if missed() < before:
                    break
                length /= 2
        else:
            raise SystemExit(f"no convergence in step {number + 1} of {steps}; residual {before:.0e}")
    form.Apply(field.vec, residual)
    seconds = process_time() - started
    forces, moved = residual.FV().NumPy(), field.vec.FV().NumPy()
    count = space.ndof // 2
    mine = {name: np.array(list(space.components[0].GetDofs(mesh.Boundaries(name)))) for name in _names()}
    at = [
        np.array([mesh[ngs.NodeId(ngs.VERTEX, n)].point for n in np.flatnonzero(mine[name][: mesh.nv])])
        + np.column_stack([moved[:count][: mesh.nv], moved[count:][: mesh.nv]])[mine[name][: mesh.nv]]
        for name in rings.BOUNDARIES
    ]
    vertices = np.arange(count) < mesh.nv
    hoop = -(forces[count:][mine["outer-x"] & vertices].sum() + forces[:count][mine["outer-y"] & vertices].sum()) / 2
    return _row(setting, at, hoop, space.ndof, iterations, seconds)


def _names() -> tuple[str, ...]:
    return (*rings.BOUNDARIES, "outer-x", "outer-y")


def calculix(setting: Setting) -> dict[str, Any]:
    """Write a deck, run CalculiX on it, and read what it prints."""
    import numpy as np

    with tempfile.TemporaryDirectory() as folder:
        deck, bottom = _deck(setting)
        Path(folder, "rings.inp").write_text(deck)
        started = perf_counter()
        alone = {**os.environ, "OMP_NUM_THREADS": "1"}
        ended = subprocess.run(["ccx", "rings"], cwd=folder, capture_output=True, text=True, check=False, env=alone)
        seconds = perf_counter() - started
        printed = Path(folder, "rings.dat")
        if "*ERROR" in ended.stdout or not printed.exists() or not printed.read_text().strip():
            wrong = [line for line in ended.stdout.splitlines() if "*ERROR" in line]
            raise SystemExit(f"ccx: {(wrong or ['no result'])[0].strip()}")
        tables = _tables(printed.read_text())
        history = Path(folder, "rings.sta").read_text().splitlines()[2:]
        iterations = sum(int(line.split()[3]) for line in history if len(line.split()) > 3)
    at = []
    for name in rings.BOUNDARIES:
        numbers, moved = tables["displacements", name.upper()]
        at.append(np.array([bottom[int(number)] for number in numbers]) + moved[:, :2])
    pulls = [tables["forces", f"OUTER-{side}"][1].sum(0) / THICKNESS for side in "XY"]
    hoop = -float(pulls[0][1] + pulls[1][0]) / 2
    return _row(setting, at, hoop, 0, iterations, seconds)


def _row(
    setting: Setting, at: list[Any], hoop: float, unknowns: int, iterations: int, seconds: float
) -> dict[str, Any]:
    found = rings.compared(setting.problem, *at, hoop=hoop)
    return {
        **{f"error_{name}": value for name, value in found.items()},
        "unknowns": unknowns,
        "iterations": iterations,
        "seconds": round(seconds, 3),
        "phases": json.dumps({}),
    }


def _deck(setting: Setting) -> tuple[str, dict[int, tuple[float, float]]]:
    """Return the deck, and the places at rest of the vertices below, by number."""
    import ngsolve as ngs

    discretisation, stiffness = _mesh(setting)
    mesh, curved = discretisation.bodies.mesh, setting.order > 1
    places = [tuple(vertex.point) for vertex in mesh.vertices]
    middle = _middles(mesh) if curved else {}
    flat = places + list(middle.values())
    of_edge = {edge: len(places) + number for number, edge in enumerate(middle)}
    layers = 3 if curved else 2
    count = len(flat)
    lines = ["*NODE, NSET=ALL"]
    for layer in range(layers):
        height = THICKNESS * layer / (layers - 1)
        lines += [f"{layer * count + n + 1}, {x:.15g}, {y:.15g}, {height:.15g}" for n, (x, y) in enumerate(flat)]
    surfaces: dict[str, list[str]] = {}
    lines.append(f"*ELEMENT, TYPE={'C3D15' if curved else 'C3D6'}, ELSET=BODIES")
    named = {edge.edges[0].nr: edge.mat for edge in mesh.Elements(ngs.BND)}
    for element in mesh.Elements(ngs.VOL):
        corners = [vertex.nr for vertex in element.vertices]
        (a, b, c) = (places[n] for n in corners)
        if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]):
            corners[1], corners[2] = corners[2], corners[1]
        sides = [tuple(sorted((corners[i], corners[(i + 1) % 3]))) for i in range(3)]
        top = count * (layers - 1)
        nodes = corners + [n + top for n in corners]
        if curved:
            ring = [of_edge[side] for side in sides]
            nodes += ring + [n + top for n in ring] + [n + count for n in corners]
        lines.append(f"{element.nr + 1}, " + ", ".join(str(n + 1) for n in nodes))
        for edge in element.edges:
            ends = tuple(sorted(vertex.nr for vertex in mesh[edge].vertices))
            if edge.nr in named:
                surfaces.setdefault(named[edge.nr], []).append(f"{element.nr + 1}, S{3 + sides.index(ends)}")
    for name, vertices in _vertices(mesh).items():
        lines.append(f"*NSET, NSET={name.upper()}")
        lines += [f"{n + 1}," for n in vertices]
        sides = [of_edge[pair] for pair in middle if pair[0] in vertices and pair[1] in vertices] if curved else []
        whole = [layer * count + n + 1 for layer in range(layers) for n in (*vertices, *sides)]
        lines.append(f"*NSET, NSET={name.upper()}-ALL")
        lines += [f"{n}," for n in whole]
    for name in ("inner-rim", "outer-bore", "inner-bore"):
        lines += [f"*SURFACE, NAME=S-{name.upper()}, TYPE=ELEMENT", *surfaces[name]]
    kappa = rings.split(setting.problem)[1]
    lines += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, MOONEY-RIVLIN"]
    lines += [f"{rings.C1 / 2}, {rings.C2 / 2}, {2 / kappa}"]
    lines += ["*SOLID SECTION, ELSET=BODIES, MATERIAL=RUBBER", "*SURFACE INTERACTION, NAME=PRESS"]
    lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness:.6g}, 0.01"]
    lines += ["*CONTACT PAIR, INTERACTION=PRESS, TYPE=SURFACE TO SURFACE", "S-OUTER-BORE, S-INNER-RIM"]
    lines += ["*BOUNDARY", "ALL, 3, 3"]
    for body, (side, axis) in product(("INNER", "OUTER"), (("X", 2), ("Y", 1))):
        lines.append(f"{body}-{side}-ALL, {axis}, {axis}")
    lines += ["*STEP, NLGEOM, INC=1000", "*STATIC", "0.1, 1.0, 1e-6, 0.2"]
    pressure = rings.PROBLEMS[setting.problem][3]
    if pressure is not None:
        lines.append("*DLOAD")
        lines += [f"{entry.split(',')[0]}, P{entry[-1]}, {pressure}" for entry in surfaces["inner-bore"]]
    for name in rings.BOUNDARIES:
        lines += [f"*NODE PRINT, NSET={name.upper()}, FREQUENCY=1000", "U"]
    for side in "XY":
        lines += [f"*NODE PRINT, NSET=OUTER-{side}-ALL, FREQUENCY=1000", "RF"]
    return "\n".join([*lines, "*END STEP", ""]), {n + 1: place for n, place in enumerate(places)}


def _vertices(mesh: Any) -> dict[str, list[int]]:
    import ngsolve as ngs

    sets: dict[str, set[int]] = {}
    for edge in mesh.Elements(ngs.BND):
        sets.setdefault(edge.mat, set()).update(vertex.nr for vertex in edge.vertices)
    return {name: sorted(vertices) for name, vertices in sets.items()}


def _middles(mesh: Any) -> dict[tuple[int, int], tuple[float, float]]:
    """Return the middle of each edge by its vertices; edges of circles are curved."""
    import ngsolve as ngs
    import numpy as np

    points = np.array([vertex.point for vertex in mesh.vertices])
    ends = [tuple(sorted(vertex.nr for vertex in edge.vertices)) for edge in mesh.edges]
    middles = {pair: points[list(pair)].mean(0) for pair in ends}
    for edge in mesh.Elements(ngs.BND):
        if edge.mat.endswith(("bore", "rim")):
            pair = tuple(sorted(v.nr for v in edge.vertices))
            radius = np.linalg.norm(points[list(pair)], axis=1).mean()
            middles[pair] = middles[pair] * (radius / np.linalg.norm(middles[pair]))
    return {pair: (float(place[0]), float(place[1])) for pair, place in middles.items()}


def _tables(text: str) -> dict[tuple[str, str], tuple[list[float], Any]]:
    """Return the last printed table of each quantity and set: numbers of nodes, and their vectors."""
    import numpy as np

    tables: dict[tuple[str, str], list[list[float]]] = {}
    key = ("", "")
    for line in text.splitlines():
        words = line.split()
        if "for set" in line:
            key = words[0], words[words.index("set") + 1].removesuffix("-ALL")
            tables[key] = []
        elif words:
            tables[key].append([float(word) for word in words])
    return {key: ([row[0] for row in rows], np.array(rows)[:, 1:]) for key, rows in tables.items() if rows}


SOLVERS = {"naive": naive, "calculix": calculix}
