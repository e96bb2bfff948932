"""CalculiX (`ccx`) on the rings, if it is installed.

Linear wedges of one layer that are held across (the deck for quadratic ones, C3D15, is written, too, but CalculiX 2.20
refuses its elements), its Mooney-Rivlin law, whose volumetric part is ``kappa/2 (J - 1)^2``, and a linear penalty from
surface to surface. Its seconds are those on the clock.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any

import ngsolve as ngs
import numpy as np

from tools.studies.work_precision import rings
from tools.studies.work_precision.grid import Setting
from tools.studies.work_precision.rings_elsewhere import mesh_and_stiffness, row

THICKNESS = 0.05


def calculix(setting: Setting) -> dict[str, Any]:
    """Write a deck, run CalculiX on it, and read what it prints."""
    with tempfile.TemporaryDirectory() as folder:
        deck, bottom = deck_of(setting)
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
    return row(setting, at, hoop, 0, iterations, seconds)


def deck_of(setting: Setting) -> tuple[str, dict[int, tuple[float, float]]]:
    """Return the deck, and the places at rest of the vertices below, by number."""
    mesh, stiffness = mesh_and_stiffness(setting)
    curved = setting.order > 1
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
        across = [of_edge[pair] for pair in middle if pair[0] in vertices and pair[1] in vertices] if curved else []
        whole = [layer * count + n + 1 for layer in range(layers) for n in (*vertices, *across)]
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
    sets: dict[str, set[int]] = {}
    for edge in mesh.Elements(ngs.BND):
        sets.setdefault(edge.mat, set()).update(vertex.nr for vertex in edge.vertices)
    return {name: sorted(vertices) for name, vertices in sets.items()}


def _middles(mesh: Any) -> dict[tuple[int, int], tuple[float, float]]:
    """Return the middle of each edge by its vertices; edges of circles are curved."""
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
