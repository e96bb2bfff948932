"""A manufactured contact problem at large strain, and the rates at which errors fall.

    python -m tools.references manufactured [--problem opening] [--method mortar] [--order 2] [--meshes 4] [--out FILE]

Two blocks of width 1 and height 1/2, one on the other, are bent, sheared and compressed by deformations that are
chosen. With ``s = 1 + 2 Y`` below, ``t = 1 - 2 Y`` above, and ``xi = X + 0.03 sin(2 pi X)``, the place below on which a
place of the upper wall comes to lie, so that walls slide on each other:

    below:  u = s (c(X) - (X, 0)),               c(X) = (1.25 X + 0.02 sin(pi X), -0.10 - 0.03 cos(pi X))
    above:  u = t (c(xi) - (X, 0)) + (1 - t) (0.1, -0.2) + t^2 (0, gap)

The interface is closed all along but for a gap that is chosen, as is the contact pressure, which has one sign and
vanishes where X = 0.55 above:

opening
    ``gap = X (1 - X) Re z^(3/2)`` with ``z = X - 0.55 + i Y``, and ``pressure = sqrt(xi_0 - xi)``: contact ends there
    as any contact does. Displacements are in H^(5/2 - eps): the energy norm falls with min(k, 3/2), no faster.
touching
    No gap, and ``pressure = 2 (xi_0 - xi)^2``. Everything is smooth, and each order may show its own rate.

Bottom, top and sides are held where they come to lie, which is linear along each. Loads follow: the force ``-Div P``
in the bodies, and on the walls what contact does not bear, ``P N + p cof(F) N``. Principal stretches reach from 0.65 to
1.4. P is written out here by hand; NGSolve derives it once more by x and y. Meshes are unstructured and do not match.

Errors are relative: of displacements in L2 and of their gradients in L2, and of contact pressures, per reference
length, in L2 along the lower wall.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import inf, log, pi, sqrt
from pathlib import Path
from typing import Any

import click
import ngsolve
import numpy as np
from netgen import occ

from ngcell import Body, BodyForce, BodyScene, BodySupport, MooneyRivlin, Mortar, Penalty, Traction
from tools import tables
from tools.commands import described
from tools.solutions import solved

C1, C2, KAPPA = 0.6, 0.4, 4.0
TOP_TRANSLATION = (0.1, -0.2)
#: Place on the upper wall where pressure and gap vanish.
END = 0.55
PROBLEMS, METHODS = ("opening", "touching"), ("mortar", "penalty")
#: Elements above are smaller by this factor.
MISMATCH = 0.8
COARSEST = 0.25
ERRORS = ("displacement", "gradient", "pressure")


@dataclass(frozen=True)
class Exact:
    """The chosen deformation and pressure.

    Parameters
    ----------
    problem : str
        One of `PROBLEMS`.
    """

    problem: str

    @cached_property
    def displacement(self) -> dict[str, Any]:
        """Displacement of each body, a coefficient function."""
        x, y = ngsolve.x, ngsolve.y
        along, up = _curve(x)
        s, t = 1 + 2 * y, 1 - 2 * y
        below = ngsolve.CF((s * (along - x), s * up))
        along, up = _curve(_facing(x))
        opening = x * (1 - x) * _power(x - END, y) if self.problem == "opening" else 0.0
        above = ngsolve.CF(
            (t * (along - x) + (1 - t) * TOP_TRANSLATION[0], t * up + (1 - t) * TOP_TRANSLATION[1] + t * t * opening)
        )
        return {"below": below, "above": above}

    def pressure(self, below: Any) -> Any:
        """True contact pressure at a place on the lower wall; takes numbers, arrays and coefficient functions."""
        from_end = END + 0.03 * np.sin(2 * pi * END) - below
        if self.problem == "touching":
            return 2 * from_end * from_end
        if isinstance(below, ngsolve.CoefficientFunction):
            return ngsolve.IfPos(from_end, ngsolve.sqrt(ngsolve.IfPos(from_end, from_end, 1.0)), 0.0)
        return np.sqrt(np.maximum(from_end, 0.0))

    def nominal_pressure(self, below: np.ndarray) -> np.ndarray:
        """Contact pressure per reference length, at places on the lower wall."""
        step = 1e-30
        slopes = [part.imag / step for part in _curve(below + 1j * step, np)]
        return np.asarray(self.pressure(below) * np.hypot(*slopes))

    def gradient(self, body: str) -> Any:
        """Displacement gradient of a body, a coefficient function."""
        parts = [self.displacement[body][row].Diff(axis) for row in range(2) for axis in (ngsolve.x, ngsolve.y)]
        return ngsolve.CF(tuple(parts), dims=(2, 2))

    @cached_property
    def loads(self) -> list[BodyForce | Traction]:
        """What holds the bodies in balance with the chosen deformation and pressure."""
        loads: list[BodyForce | Traction] = []
        for body, wall, normal, pressure in (
            ("below", "below_top", 1.0, self.pressure(ngsolve.x)),
            ("above", "above_bottom", -1.0, self.pressure(_facing(ngsolve.x))),
        ):
            gradient = ngsolve.Id(2) + self.gradient(body)
            stress = first_piola(*(gradient[i, j] for i in range(2) for j in range(2)))
            force = [-(stress[2 * i].Diff(ngsolve.x) + stress[2 * i + 1].Diff(ngsolve.y)) for i in range(2)]
            loads.append(BodyForce(body=body, vector=_always(*(part.Compile() for part in force))))
            borne = (-pressure * gradient[1, 0], pressure * gradient[0, 0])  # p cof(F) applied to (0, 1)
            traction = [normal * (stress[2 * i + 1] + borne[i]) for i in range(2)]
            loads.append(Traction(boundary=wall, vector=_always(*(part.Compile() for part in traction))))
        return loads


def first_piola(xx: Any, xy: Any, yx: Any, yy: Any) -> list[Any]:
    """Return xx, xy, yx, yy of P [stress] for a plane deformation gradient: ``dW/dF``, written out."""
    log_, exp = (ngsolve.log, ngsolve.exp) if isinstance(xx, ngsolve.CoefficientFunction) else (np.log, np.exp)
    jacobian = xx * yy - xy * yx
    inverse = [yy / jacobian, -yx / jacobian, -xy / jacobian, xx / jacobian]  # F^-T
    square = xx * xx + xy * xy + yx * yx + yy * yy
    scale = exp(-2 / 3 * log_(jacobian))
    first, second = square + 1, square + jacobian * jacobian
    # The second invariant of diag(C, 1) is tr C + det C; its derivative is 2 F + 2 J^2 F^-T.
    return [
        C1 * scale * (entry - first / 3 * turned)
        + C2 * scale * scale * (entry + (jacobian * jacobian - 2 / 3 * second) * turned)
        + KAPPA * log_(jacobian) * turned
        for entry, turned in zip((xx, xy, yx, yy), inverse, strict=True)
    ]


def _curve(x: Any, functions: Any = ngsolve) -> tuple[Any, Any]:
    """Deformed place of a place on the lower wall."""
    return 1.25 * x + 0.02 * functions.sin(pi * x), -0.10 - 0.03 * functions.cos(pi * x)


def _facing(x: Any) -> Any:
    """Place on the lower wall on which a place on the upper wall comes to lie."""
    return x + 0.03 * ngsolve.sin(2 * pi * x)


def _power(x: Any, y: Any) -> Any:
    """Return ``Re (x + i y)^(3/2)`` for y >= 0, without cancellation."""
    radius = ngsolve.sqrt(x * x + y * y)
    larger = ngsolve.sqrt((radius + ngsolve.IfPos(x, x, -x)) / 2)
    smaller = y / (2 * larger)
    real, imaginary = ngsolve.IfPos(x, larger, smaller), ngsolve.IfPos(x, smaller, larger)
    return x * real - y * imaginary


def _always(*parts: Any) -> Any:
    return lambda x, y: parts


def scene(exact: Exact, method: str, order: int, size: float) -> BodyScene:
    """Return the two blocks with their loads."""
    material = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA)
    bodies = [
        Body(_block("below", -0.5, size), material, "below", ("below_left", "below_right", "below_bottom")),
        Body(_block("above", 0.0, MISMATCH * size), material, "above", ("above_left", "above_right", "above_top")),
    ]
    supports = [
        BodySupport("below_left", gradient=((0.0, 0.0), (0.0, -0.26)), translation=(0.0, -0.13)),
        BodySupport("below_right", gradient=((0.0, 0.5), (0.0, -0.14)), translation=(0.25, -0.07)),
        BodySupport("above_left", gradient=((0.0, 0.2), (0.0, -0.14)), translation=(0.0, -0.13)),
        BodySupport("above_right", gradient=((0.0, -0.3), (0.0, -0.26)), translation=(0.25, -0.07)),
        BodySupport("below_bottom"),
        BodySupport("above_top", translation=TOP_TRANSLATION),
    ]
    contact = Mortar() if method == "mortar" else Penalty()
    return BodyScene(
        bodies, supports, size=size, order=order, levels=1, contact=contact, loads=exact.loads, accuracy=inf
    )


def _block(name: str, bottom: float, size: float) -> Any:
    face = occ.Rectangle(1.0, 0.5).Face().Move((0.0, bottom, 0.0)).faces[0]
    for direction, low, high in ((occ.X, "left", "right"), (occ.Y, "bottom", "top")):
        face.edges.Min(direction).name, face.edges.Max(direction).name = f"{name}_{low}", f"{name}_{high}"
    face.maxh = size
    return face


def errors(problem: str, method: str, order: int, size: float) -> dict[str, float]:
    """Solve on one mesh, and return the relative errors, the unknowns and the iterations."""
    exact = Exact(problem)
    solution = solved(scene(exact, method, order, size))
    mesh, found = solution.mesh, solution.displacement
    chosen = mesh.MaterialCF(exact.displacement)
    slopes = mesh.MaterialCF({body: exact.gradient(body) for body in exact.displacement})

    def relative(one: Any, two: Any) -> float:
        away, whole = (
            ngsolve.Integrate(ngsolve.InnerProduct(field, field), mesh, order=2 * order + 6)
            for field in (one - two, two)
        )
        return sqrt(away / whole)

    wall = solution.wall_pressures("below_top")
    pressure = exact.nominal_pressure(wall.place[:, 0])
    return {
        "displacement": relative(found, chosen),
        "gradient": relative(ngsolve.Grad(found), slopes),
        "pressure": sqrt(float(wall.length @ (wall.nominal - pressure) ** 2) / float(wall.length @ pressure**2)),
        "unknowns": solution.unknowns,
        "iterations": solution.last.record.iterations,
        "certified": solution.last.record.certified,
    }


def rate(coarse: float, fine: float, ratio: float = 2.0) -> float:
    """Return the exponent of the element size with which an error falls."""
    return log(coarse / fine) / log(ratio)


def lines(problem: str, method: str, order: int, meshes: int) -> Iterator[tuple[str, ...]]:
    """Yield the lines of a table, a line a mesh."""
    before: dict[str, float] = {}
    for level in range(meshes):
        size = COARSEST / 2**level
        found = errors(problem, method, order, size)
        cells = [f"{found[name]:.2e}" for name in ERRORS]
        cells += [f"{rate(before[name], found[name]):.2f}" if before else "" for name in ERRORS]
        yield problem, method, f"{order}", f"{size:g}", *cells, f"{found['unknowns']}", f"{found['iterations']}"
        before = found


COLUMNS = (
    "problem", "method", "order", "h", "u in L2", "grad u in L2", "p in L2", "rate of u", "of grad u", "of p",
    "unknowns", "iterations",
)  # fmt: skip


@described(__doc__)
@click.option("--problem", "problems", type=click.Choice(PROBLEMS), multiple=True, default=PROBLEMS)
@click.option("--method", "methods", type=click.Choice(METHODS), multiple=True, default=METHODS)
@click.option("--order", "orders", type=click.IntRange(1, 4), multiple=True, default=[1, 2, 3])
@click.option("--meshes", default=4, show_default=True, help="Number of meshes, each twice as fine as the one before.")
@click.option("--out", type=click.Path(path_type=Path), help="Where the table goes, too.")
def command(problems: list[str], methods: list[str], orders: list[int], meshes: int, out: Path | None) -> None:
    """Solve all combinations and tabulate."""
    found = []
    for combination in product(problems, methods, orders):
        for line in lines(*combination, meshes):
            found.append(line)
            click.echo("  ".join(line), err=True)
    table = tables.markdown(COLUMNS, found)
    click.echo(table)
    if out is not None:
        out.write_text(f"## Manufactured contact: relative errors and rates\n\n{table}\n")
