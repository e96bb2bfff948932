"""CalculiX (`ccx`) on blocks and rings, if it is installed: quadratic hexahedra, a linear penalty, surface to surface.

Its Mooney-Rivlin has the volumetric part ``kappa/2 (J - 1)^2``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from time import perf_counter

import numpy as np

from tools.references.peers.problems import C1, C2, KAPPA, PRESSED, Grid, grids

#: Thickness of the layer, and penalty stiffness over that of a layer of elements.
THICKNESS, STIFF = 0.1, 30.0
#: Lateral faces of an element whose first direction is x, by the side of the grid.
_FACES = {"first": "S6", "last": "S4", "low": "S3", "high": "S5"}


def missing() -> str:
    """Return why it cannot run here; empty where it can."""
    return "" if shutil.which("ccx") else "CalculiX: no program `ccx` (Debian: calculix-ccx)"


def force(problem: str, count: int, order: int) -> tuple[float, float, int]:
    """Return the force that `exact_force` tells, seconds on the clock, and the number of unknowns.

    Raises
    ------
    RuntimeError
        If CalculiX ends without a result.
    """
    deck, unknowns = _deck(problem, count, order)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "peer.inp").write_text(deck)
        started, alone = perf_counter(), {**os.environ, "OMP_NUM_THREADS": "1"}
        command = ["timeout", "120", "ccx", "peer"]
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=alone)
        seconds = perf_counter() - started
        printed = Path(folder, "peer.dat")
        lines = printed.read_text().splitlines() if printed.exists() else []
    times = [float(line.split()[-1]) for line in lines if "total force" in line]
    if not times or abs(times[-1] - 1) > 1e-6:
        wrong = [line.strip() for line in ended.stdout.splitlines() if "*ERROR" in line]
        raise RuntimeError((wrong or ["no result"])[0])
    rows = [line.split() for line in lines if len(line.split()) == 3 and "total" not in line]
    numbers = [[float(word) for word in row] for row in rows]
    bears = [float(np.abs(row).max()) for row in numbers[-(2 if problem == "rings" else 1) :]]
    return sum(bears) / len(bears) / THICKNESS, seconds, unknowns


def _deck(problem: str, count: int, order: int) -> tuple[str, int]:
    bodies = grids(problem, count)
    lines: list[str] = []
    first = 1
    for name, grid in zip(("ONE", "TWO"), bodies, strict=True):
        text, used = _body(name, grid, first, order)
        lines += text
        first += used
    kappa = KAPPA[problem]
    depth = 1.0 / count if problem == "blocks" else 0.5 / count
    lines += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, MOONEY-RIVLIN", f"{C1 / 2}, {C2 / 2}, {2 / kappa}"]
    lines += ["*SOLID SECTION, ELSET=E-ONE, MATERIAL=RUBBER", "*SOLID SECTION, ELSET=E-TWO, MATERIAL=RUBBER"]
    lines += ["*SURFACE INTERACTION, NAME=PRESS", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    lines += [f"{STIFF * (kappa + 4 / 3) / depth:.6g}, 1e-3"]
    sides = ("HIGH", "LOW") if problem == "blocks" else ("LAST", "FIRST")
    lines += ["*CONTACT PAIR, INTERACTION=PRESS, TYPE=SURFACE TO SURFACE", f"S-TWO-{sides[1]}, S-ONE-{sides[0]}"]
    lines += ["*BOUNDARY", "N-ONE, 3, 3", "N-TWO, 3, 3", *_supports(problem)]
    lines += ["*STEP, NLGEOM, INC=500", "*STATIC", "0.1, 1.0, 1e-6, 0.2"]
    if problem == "blocks":
        lines += ["*BOUNDARY", f"N-TWO-HIGH, 2, 2, {2 * (PRESSED - 1)}"]
    for held in ("N-TWO-HIGH",) if problem == "blocks" else ("N-TWO-LOW", "N-TWO-HIGH"):
        lines += [f"*NODE PRINT, NSET={held}, TOTALS=ONLY, FREQUENCY=1", "RF"]
    return "\n".join([*lines, "*END STEP", ""]), 2 * (first - 1)


def _supports(problem: str) -> list[str]:
    if problem == "blocks":
        sides = [f"N-{body}-{side}, 1, 1" for body, side in product(("ONE", "TWO"), ("FIRST", "LAST"))]
        return [*sides, "N-ONE-LOW, 2, 2"]
    return [f"N-{body}-{side}, {axis}, {axis}" for body in ("ONE", "TWO") for side, axis in (("LOW", 2), ("HIGH", 1))]


def _body(name: str, grid: Grid, first: int, order: int) -> tuple[list[str], int]:
    """Return nodes, elements, sets and surfaces of a body, and how many numbers of nodes it takes."""
    width, height = grid.places.shape[:2]
    numbers = np.arange(3 * width * height).reshape(3, width, height) + first
    lines, element = [f"*NODE, NSET=N-{name}"], first
    used = set()
    elements = [f"*ELEMENT, TYPE={'C3D20R' if order == 2 else 'C3D8'}, ELSET=E-{name}"]
    faces: dict[str, list[str]] = {side: [] for side in _FACES}
    for i, j in product(range(0, width - 1, 2), range(0, height - 1, 2)):
        nodes = list(_nodes(numbers, i, j))[: 20 if order == 2 else 8]
        used |= set(nodes)
        elements.append(f"{element}, " + ", ".join(map(str, nodes[:15])) + ("," if order == 2 else ""))
        elements += [", ".join(map(str, nodes[15:]))] if order == 2 else []
        for side, at in (("first", i == 0), ("last", i == width - 3), ("low", j == 0), ("high", j == height - 3)):
            faces[side] += [f"{element}, {_FACES[side]}"] if at else []
        element += 1
    for layer, i, j in product(range(3), range(width), range(height)):
        if numbers[layer, i, j] in used:
            x, y = grid.places[i, j]
            lines.append(f"{numbers[layer, i, j]}, {x:.15g}, {y:.15g}, {layer * THICKNESS / 2:.15g}")
    lines += elements
    ends = {"first": numbers[:, 0], "last": numbers[:, -1], "low": numbers[:, :, 0], "high": numbers[:, :, -1]}
    for side, of in ends.items():
        lines += [f"*NSET, NSET=N-{name}-{side.upper()}", *(f"{n}," for n in of.ravel() if n in used)]
        lines += [f"*SURFACE, NAME=S-{name}-{side.upper()}, TYPE=ELEMENT", *faces[side]]
    return lines, numbers.size


def _nodes(numbers: np.ndarray, i: int, j: int) -> Iterator[int]:
    """Yield the nodes of an element: corners below and above, middles of sides below, above, and half-way up."""
    corners = ((i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2))
    middles = ((i + 1, j), (i + 2, j + 1), (i + 1, j + 2), (i, j + 1))
    for layer, places in ((0, corners), (2, corners), (0, middles), (2, middles), (1, corners)):
        yield from (int(numbers[layer][place]) for place in places)
