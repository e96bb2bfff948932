"""CalculiX (`ccx`), if it is installed: quadratic hexahedra, a linear penalty, surface to surface.

Its Mooney-Rivlin has the volumetric part ``kappa/2 (J - 1)^2``. A deck has node sets `N-<body>` and `N-<number>`, the
support of that number, and surfaces `S-<body>-<side>`; plane strain is a layer of elements that is held across.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from tools.references.peers.answer import LIMIT, STOPPED, Answer
from tools.references.peers.grids import Array, Grid
from tools.references.peers.problems import C1, C2, Problem, Support, Wall

#: Thickness of the layer, and penalty stiffness over that of a layer of elements.
THICKNESS, STIFF = 0.1, 30.0
#: Lateral faces of an element, by its nodes: the sides where its directions begin and end.
_FACES = {"S6": np.s_[0, :], "S4": np.s_[2, :], "S3": np.s_[:, 0], "S5": np.s_[:, 2]}
#: Corners and middles of the sides of an element, and layers and places of its nodes in their order, by order.
_CORNERS, _MIDDLES = ((0, 2, 2, 0), (0, 0, 2, 2)), ((1, 2, 1, 0), (0, 1, 2, 1))
_LINEAR = ((0, _CORNERS), (2, _CORNERS))
_ORDERED = {1: _LINEAR, 2: (*_LINEAR, (0, _MIDDLES), (2, _MIDDLES), (1, _CORNERS))}


def missing() -> str:
    """Return why it cannot run here; empty where it can."""
    return "" if shutil.which("ccx") else "CalculiX: no program `ccx` (Debian: calculix-ccx)"


def solve(problem: Problem, order: int) -> Answer:
    """Solve a problem.

    Raises
    ------
    RuntimeError
        If CalculiX ends without a result.
    """
    text, unknowns = deck(problem, order)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "peer.inp").write_text(text)
        started, alone = perf_counter(), {**os.environ, "OMP_NUM_THREADS": "1"}
        command = ["timeout", str(LIMIT), "ccx", "peer"]
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=alone)
        seconds = perf_counter() - started
        printed = Path(folder, "peer.dat")
        found = _printed(printed.read_text()) if printed.exists() else {}
    time = max((time for _, time in found), default=0.0)
    if abs(time - 1) > 1e-6:
        wrong = [line.strip() for line in ended.stdout.splitlines() if "*ERROR" in line]
        raise RuntimeError(STOPPED if ended.returncode == 124 else (wrong or ["no result"])[0])
    shares = {number: problem.supports[number].shares for number in _measured(problem)}
    force = sum(float(np.dot(share, found[f"N-{number}", time][:2])) for number, share in shares.items()) / THICKNESS
    if problem.opening is None:
        return Answer(force, None, seconds, unknowns)
    parted = found["N-SECOND", time][:2] - found["N-FIRST", time][:2]
    return Answer(force, float(parted @ problem.normal), seconds, unknowns)


def _printed(text: str) -> dict[tuple[str, float], Array]:
    """Return the last line of numbers of each table: forces of a set, or displacements of its node, by set and time."""
    found, key = {}, None
    for line in text.splitlines():
        words = line.split()
        if "set" in words:
            key = words[words.index("set") + 1], float(words[-1])
        elif words and key is not None:
            found[key] = np.array([float(word) for word in words[-3:]])
    return found


def deck(problem: Problem, order: int) -> tuple[str, int]:
    """Return the deck, and how many unknowns it has in the plane."""
    bodies, first = {}, 1
    for name, grid in problem.bodies.items():
        bodies[name] = _Numbered(name.upper(), grid, first, _used(grid, order))
        first += 3 * len(grid.places)
    lines = [line for name, body in bodies.items() for line in body.lines(_walls(problem, name))]
    lines += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, MOONEY-RIVLIN", f"{C1 / 2}, {C2 / 2}, {2 / problem.kappa}"]
    lines += [f"*SOLID SECTION, ELSET=E-{body.name}, MATERIAL=RUBBER" for body in bodies.values()]
    depth = next(iter(problem.bodies.values())).size
    lines += ["*SURFACE INTERACTION, NAME=PRESS", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    lines += [f"{STIFF * (problem.kappa + 4 / 3) / depth:.6g}, 1e-3"]
    for pair in problem.pairs:
        walls = [f"S-{body}-{side}".upper() for body, side in (pair.second, pair.first)]
        lines += ["*CONTACT PAIR, INTERACTION=PRESS, TYPE=SURFACE TO SURFACE", ", ".join(walls)]
    for number, support in enumerate(problem.supports):
        lines += [f"*NSET, NSET=N-{number}", *(f"{node}," for node, _ in bodies[support.body].held(support))]
    for name, (body, side) in _opening(problem).items():
        lines += [f"*NSET, NSET=N-{name}", f"{problem.bodies[body].middle(side) + bodies[body].first},"]
    lines += ["*BOUNDARY", *(f"N-{body.name}, 3, 3" for body in bodies.values())]
    lines += ["*STEP, NLGEOM, INC=500", "*STATIC", "0.1, 1.0, 1e-6, 0.2", "*BOUNDARY"]
    for support in problem.supports:
        for node, moved in bodies[support.body].held(support):
            lines += [f"{node}, {axis + 1}, {axis + 1}, {moved[axis]:.12g}" for axis in support.axes]
    lines += [line for number in _measured(problem) for line in (f"*NODE PRINT, NSET=N-{number}, TOTALS=ONLY", "RF")]
    lines += [line for name in _opening(problem) for line in (f"*NODE PRINT, NSET=N-{name}", "U")]
    return "\n".join([*lines, "*END STEP", ""]), 2 * int(sum(body.used.sum() for body in bodies.values()))


def _walls(problem: Problem, body: str) -> list[str]:
    """Return the sides of a body that may touch another."""
    return [side for pair in problem.pairs for name, side in (pair.first, pair.second) if name == body]


def _measured(problem: Problem) -> list[int]:
    """Return the numbers of the supports whose forces count."""
    return [number for number, support in enumerate(problem.supports) if any(support.shares)]


def _opening(problem: Problem) -> dict[str, Wall]:
    """Return the walls between whose middles the opening is measured, by the names of their sets."""
    return {} if problem.opening is None else {"FIRST": problem.opening.first, "SECOND": problem.opening.second}


def _used(grid: Grid, order: int) -> NDArray[np.bool_]:
    """Return which nodes elements have, shape (3, nodes): below, half-way up, and above."""
    used = np.zeros((3, len(grid.places)), dtype=bool)
    for layer, at in _ORDERED[order]:
        used[layer, grid.elements[:, at[0], at[1]]] = True
    return used


@dataclass(frozen=True, eq=False)
class _Numbered:
    """A body whose nodes and elements have numbers from `first` on; `used` is as in `_used`."""

    name: str
    grid: Grid
    first: int
    used: NDArray[np.bool_]

    def lines(self, walls: list[str]) -> Iterator[str]:
        """Yield nodes, elements, and walls as surfaces."""
        is_curved = bool(self.used[1].any())
        yield f"*NODE, NSET=N-{self.name}"
        # A field has twenty characters: of longer ones CalculiX would lose the exponent.
        for layer, node in np.argwhere(self.used):
            x, y = self.grid.places[node]
            yield f"{self._number(layer, node)}, {x:.12g}, {y:.12g}, {layer * THICKNESS / 2:.12g}"
        yield f"*ELEMENT, TYPE={'C3D20R' if is_curved else 'C3D8'}, ELSET=E-{self.name}"
        for number, nodes in enumerate(self.grid.elements, self.first):
            layers = _ORDERED[2 if is_curved else 1]
            words = [str(number), *(str(self._number(layer, node)) for layer, at in layers for node in nodes[at])]
            yield ", ".join(words[:16]) + ("," if is_curved else "")
            yield from [", ".join(words[16:])] if is_curved else []
        for side in walls:
            yield f"*SURFACE, NAME=S-{self.name}-{side.upper()}, TYPE=ELEMENT"
            yield from self._faces(side)

    def held(self, support: Support) -> Iterator[tuple[int, Array]]:
        """Yield the numbers of the nodes of a support, and their displacements [length]."""
        nodes = self.grid.on(support.sides)
        for layer, at in np.argwhere(self.used[:, nodes]):
            yield self._number(layer, nodes[at]), support.displacement(self.grid.places[nodes[at]])

    def _number(self, layer: int, node: int) -> int:
        return int(self.first + layer * len(self.grid.places) + node)

    def _faces(self, side: str) -> Iterator[str]:
        on = set(self.grid.sides[side].tolist())
        for number, nodes in enumerate(self.grid.elements, self.first):
            yield from (f"{number}, {face}" for face, at in _FACES.items() if on.issuperset(nodes[at].tolist()))
