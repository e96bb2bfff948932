"""In-plane moduli of endless tied tissues at rest, against those of frames of beams by Gibson and Ashby.

    python -m tools.references moduli [--ratio 0.02 --ratio 0.1 ...] [--out FILE]

One cell is meshed as its tissue meshes it, and what leaves it on one side comes back on the other: its walls are tied
to those of its own copies, displaced by the mean strain. That is an endless tied tissue, without any boundary. The
tangent at rest gives its moduli; the mesh is refined until the last step changes them by less than is told.

The closed forms are those of Gibson and Ashby, Cellular Solids (1997), section 4.3, in plane strain, with walls as
beams that bend, shear and stretch: k = 2.4 + 1.5 nu stands for shear. A cell with struts of length l at the angle theta
to x and upright ones of length h is the regular honeycomb for theta = 30 degrees and h = l, and bricks in running bond
for theta = 0 and l half of the brick. Beams meet in points: where walls of thickness t meet they stiffen each other,
which is of first order in t / l and no part of the closed forms. Rows go to `tools/results/moduli.csv`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any, Literal

import click
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import null_space
from scipy.sparse.linalg import splu

from ngcell import Case
from ngcell.build.discretisation import Discretisation, discretise
from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.tissues.outlined import OutlinedCells
from ngcell.problem.problem import Problem
from tools import tables
from tools.commands import described
from tools.places import RESULTS

Array = NDArray[np.float64]

TABLE = RESULTS / "moduli.csv"
RATIOS = (0.02, 0.03, 0.05, 0.07, 0.1, 0.15)
MODULI = ("E_x", "E_y", "G")
#: Shear and bulk modulus of the walls: Poisson's ratio is 0.3.
SHEAR, BULK = 1.0, 13 / 6
_SAME = 1e-6


@dataclass(frozen=True)
class Frame:
    """An endless frame of beams: Gibson and Ashby's cell.

    Attributes
    ----------
    inclined, upright : float
        Lengths of its struts, l and h [length].
    angle : float
        Of the inclined ones to x [radian].
    """

    inclined: float
    upright: float
    angle: float

    @property
    def corners(self) -> Array:
        """Corners of a cell, anticlockwise from the lower one on the right [length], shape (6, 2)."""
        half, foot = self.inclined * np.cos(self.angle), self.upright / 2
        tip = foot + self.inclined * np.sin(self.angle)
        return np.array([(half, -foot), (half, foot), (0, tip), (-half, foot), (-half, -foot), (0, -tip)])

    @property
    def lattice(self) -> Array:
        """Where the copies of the cell next to it are [length], shape (6, 2)."""
        half, rise = self.inclined * np.cos(self.angle), self.upright + self.inclined * np.sin(self.angle)
        ahead = np.array([(2 * half, 0.0), (half, rise), (-half, rise)])
        return np.concatenate([ahead, -ahead])

    @property
    def area(self) -> float:
        """Of a cell [length**2]."""
        (width, _), (_, rise) = self.lattice[:2]
        return float(width * rise)

    def moduli(self, thickness: float, modulus: float, poisson: float) -> Array:
        """Return E along x and y and G of the frame [stress], in plane strain, with walls of this thickness [length].

        `modulus` and `poisson` are those of the walls in plane strain, ``E / (1 - nu**2)`` and ``nu / (1 - nu)``.
        """
        length, height = self.inclined, self.upright
        sin, cos, rise = np.sin(self.angle), np.cos(self.angle), height + length * np.sin(self.angle)
        thin, shear = thickness / length, 2.4 + 1.5 * poisson
        # Compliances times the modulus: those of bending and shearing, and of stretching.
        bent, stretched = (1 + shear * thin**2) / thin**3, 1 / thin
        along_x = rise / length / cos * (sin**2 * bent + cos**2 * stretched)
        along_y = cos / (rise / length) * (cos**2 * bent + (sin**2 + 2 * height / length) * stretched)
        return modulus / np.array([along_x, along_y, self._shear_compliance(thickness, shear)])

    def _shear_compliance(self, thickness: float, shear: float) -> float:
        """Return that of shear times the modulus: of upright struts that bend, and inclined ones that turn with them
        and stretch."""
        length, height = self.inclined, self.upright
        sin, cos, rise = np.sin(self.angle), np.cos(self.angle), height + length * np.sin(self.angle)
        # Displacements of a row for a force 1 in its upright struts; the moment of inertia is t**3 / 12.
        turned = height**2 * length / 2 * (1 + shear * (thickness / length) ** 2) / thickness**3
        bent = height**3 * (1 + shear * (thickness / height) ** 2) / thickness**3
        stretched = (length * cos + rise * sin / cos) ** 2 / (2 * length * thickness)
        return float(2 * length * cos * (turned + bent + stretched) / rise)


class Cell(OutlinedCells):
    """One cell of a frame, with corners wherever three cells of the endless tissue meet: those of a brick in running
    bond are straight angles in the middle of its long sides."""

    kind: Literal["cell"] = "cell"
    frame: Frame

    @property
    def grid(self) -> tuple[int, int]:
        """Number of rows, and of cells in each."""
        return 1, 1

    def drawn(self) -> Outlines:
        """Return the outline."""
        corners = self.frame.corners
        return Outlines(corners, np.array([len(corners)]), np.full(len(corners), -1))


FRAMES = {"honeycomb": Frame(1.0, 1.0, np.pi / 6), "brick": Frame(1.0, 1.0, 0.0)}


def endless(frame: Frame, thickness: float, order: int, grading: int = 3) -> Array:
    """Return E along x and y and G of the endless tied tissue [stress]; each cell has half of the common walls."""
    case = Case.model_validate(
        {
            "tissue": Cell(frame=frame, wall=thickness / 2),
            "material": {"kind": "mooney-rivlin", "c1": SHEAR, "c2": 0.0, "bulk_modulus": BULK},
            "load": {"kind": "frame", "shear": 0.0},
            "mesh": {"order": order, "grading": grading, "size": frame.inclined / 4},
            "accuracy": inf,
        }
    )
    compliance = np.linalg.inv(_stiffness(discretise(case), frame))
    return np.asarray(1 / np.diag(compliance))


def _stiffness(built: Discretisation, frame: Frame) -> Array:
    """Return mean stresses xx, yy and xy for unit strains xx, yy and 2 xy [stress], shape (3, 3)."""
    space = built.space
    problem = Problem(space, built.terms, np.zeros((2, space.size), dtype=bool))
    state = problem.at(np.zeros(space.unknowns))
    lower = sparse.csr_array((problem.linearise(state).stiffness, problem.pattern), shape=(space.unknowns,) * 2)
    matrix = lower + sparse.tril(lower, -1).T
    walls = find_surface(space.bodies, space.scalar, space.rest)
    on_walls, conditions = _conditions(walls, frame, space.size)
    free = _free_motions(on_walls, conditions, space.size)
    free = sparse.block_diag([free, free], format="csc")
    strains = np.array([((1, 0), (0, 0)), ((0, 0), (0, 1)), ((0, 0.5), (0.5, 0))])
    affine = np.array([space.affine(strain, np.zeros(2)).ravel() for strain in strains]).T
    inner = splu((free.T @ matrix @ free).tocsc(), "MMD_AT_PLUS_A", 0.0, options={"SymmetricMode": True})
    moved = affine - free @ inner.solve(free.T @ (matrix @ affine))
    return np.asarray(moved.T @ (matrix @ moved) / frame.area)


def _conditions(walls: Surface, frame: Frame, size: int) -> tuple[NDArray[np.int64], Array]:
    """Return the scalar unknowns on walls, and the conditions on them that make what is added to a mean strain the same
    on walls that are copies of each other, and zero at one corner; shape (conditions, unknowns)."""
    centres, used = walls.centres(walls.rest), np.unique(walls.dofs)
    rows = [np.eye(1, size, int(walls.dofs[0, 0]))]
    for away in frame.lattice:
        distance = np.linalg.norm(centres[:, None] + away - centres[None], axis=2)
        for one, two in np.argwhere(distance < _SAME):
            place = np.linalg.norm(walls.rest[one][:, None] + away - walls.rest[two][None], axis=2).argmin(1)
            row = np.zeros((len(place), size))
            row[:, walls.dofs[one]] += walls.nodal[one]
            row[:, walls.dofs[two]] -= walls.nodal[two][place]
            rows.append(row)
    return used, np.concatenate(rows)[:, used]


def _free_motions(on_walls: NDArray[np.int64], conditions: Array, size: int) -> sparse.csc_array:
    """Return the motions that meet the conditions as columns, shape (size, motions)."""
    inside = np.setdiff1d(np.arange(size), on_walls)
    count = len(inside)
    along = sparse.csr_array((np.ones(count), (inside, np.arange(count))), shape=(size, count))
    periodic = sparse.coo_array(null_space(conditions))
    row, column = periodic.coords
    shape = (size, periodic.shape[1])
    return sparse.hstack([along, sparse.csr_array((periodic.data, (on_walls[row], column)), shape=shape)], format="csc")


@described(__doc__)
@click.option("--ratio", "ratios", multiple=True, default=RATIOS, show_default=True, help="Thickness over length.")
@click.option("--out", default=TABLE, type=click.Path(path_type=Path), help="Where rows go.")
def command(ratios: tuple[float, ...], out: Path) -> None:
    """Compute and tabulate moduli of endless tissues beside those of frames."""
    rows = [row for name, frame in FRAMES.items() for ratio in ratios for row in compared(name, frame, ratio)]
    tables.write(out, tuple(rows[0]), rows)
    lines = [[f"{cell:.5g}" if isinstance(cell, float) else cell for cell in row.values()] for row in rows]
    click.echo(tables.markdown(tuple(rows[0]), lines))


def compared(name: str, frame: Frame, ratio: float) -> list[dict[str, Any]]:
    """Return a row for each modulus of walls with this thickness over the length of a strut, over that of walls."""
    bulk = (3 * BULK - 2 * SHEAR) / (6 * BULK + 2 * SHEAR)
    modulus = 2 * SHEAR / (1 - bulk)
    coarse, fine = (endless(frame, ratio * frame.inclined, order) for order in (4, 5))
    closed = frame.moduli(ratio * frame.inclined, modulus, bulk / (1 - bulk))
    return [
        {
            "tissue": name,
            "thickness": ratio,
            "modulus": MODULI[number],
            "over_walls": float(fine[number] / modulus),
            "mesh_error": float(abs(coarse[number] / fine[number] - 1)),
            "closed_form": float(closed[number] / modulus),
            "over_closed_form": float(fine[number] / closed[number]),
        }
        for number in range(len(MODULI))
    ]
