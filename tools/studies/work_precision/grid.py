"""What is run: settings of exact problems and of tissues, in a quick and in a full form."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

#: Methods at each size of the elements of rings, and the highest order: the finest meshes take the ones that matter.
METHODS = {
    0.25: ("mortar", "penalty x0.1", "penalty", "penalty x10"),
    0.125: ("mortar", "penalty", "penalty x10"),
    0.0625: ("mortar", "penalty"),
}
HIGHEST = {0.25: 4, 0.125: 4, 0.0625: 3}


@dataclass(frozen=True)
class Setting:
    """One run.

    Attributes
    ----------
    kind : {"rings", "case", "tissue", "naive", "calculix"}
        What the problem is, or who solves the rings.
    problem : str
        Name of the problem.
    case : str
        The shipped case, where it is one.
    method : str
        mortar, or penalty with its multiple.
    order : int
        Polynomial order.
    size : float
        Length of an element's edge; for shipped benchmark cases a factor on all of theirs.
    strategy : str
        sddp or single-step; only tissues have a choice.
    steps : int
        Load steps.
    overrides : tuple of str
        What else is set in the case.
    """

    kind: str
    problem: str
    method: str
    order: int
    size: float
    case: str = ""
    strategy: str = "single-step"
    steps: int = 1
    overrides: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The row's key, beside the version of the code."""
        parts = (self.kind, self.problem, self.method, f"order {self.order}", f"h {self.size:g}", self.strategy)
        return ", ".join((*parts, f"{self.steps} steps"))

    def row(self) -> dict[str, Any]:
        """Return its columns."""
        columns = asdict(self)
        del columns["overrides"]
        return {"run": self.label, **columns}


def grid(quick: bool) -> Iterator[Setting]:
    """All settings, the cheap ones first."""
    yield from ring_settings(quick)
    if not quick:
        yield from benchmark_settings()
    yield from tissue_settings(quick)
    yield from strategy_settings(quick)


def ring_settings(quick: bool) -> Iterator[Setting]:
    """Press-fit, parting and closing rings, nearly incompressible and, at order 1, soft."""
    problems = ("press-fit", "above") if quick else ("press-fit", "tight-fit", "pulled", "below", "touch", "above")
    sizes = (0.25, 0.125) if quick else (0.25, 0.125, 0.0625)
    for size in sizes:
        methods = ("mortar", "penalty") if quick else METHODS[size]
        orders = range(1, 4 if quick else HIGHEST[size] + 1)
        for order, method, problem in product(orders, methods, problems):
            yield Setting("rings", problem, method, order, size)
            if order == 1 and problem in ("press-fit", "above"):
                yield Setting("rings", f"{problem} soft", method, order, size)


def benchmark_settings() -> Iterator[Setting]:
    """Stacked blocks, and a half-cylinder on a block."""
    cases = {"stacked blocks": "stacked-blocks", "half-cylinder": "hertz-half-cylinder"}
    for factor, (problem, case), method in product((2.0, 1.0), cases.items(), ("mortar", "penalty")):
        yield Setting("case", problem, method, 2, factor, case)


def tissue_settings(quick: bool) -> Iterator[Setting]:
    """The empty 3x3 tissue at all settings, the other tissues at the likely ones."""
    sizes = (0.5,) if quick else (1.0, 0.5, 0.25)
    for size, order, method in product(sizes, (2, 3) if quick else (1, 2, 3, 4), ("mortar", "penalty")):
        yield Setting("tissue", "3x3 empty", method, order, size, "shear-empty-3x3")
    if quick:
        return
    for size, order, method in product((0.5, 0.25), (2, 3), ("mortar", "penalty")):
        for problem, lumen in LUMENS.items():
            yield Setting("tissue", f"3x3 {problem}", method, order, size, "shear-empty-3x3", overrides=lumen)
        if size == 0.5:
            yield Setting("tissue", "5x7 empty", method, order, size, "shear-empty", overrides=MODERATE)


#: What cells hold, beside nothing.
LUMENS = {
    "pressurised": ('lumen.kind="pressure"', "lumen.pressure=0.005"),
    "filled": (
        'lumen.kind="inclusion"',
        'lumen.material.kind="mooney-rivlin"',
        "lumen.material.c1=0.01",
        "lumen.material.c2=0.0",
        "lumen.material.bulk_modulus=1.0",
    ),
}
MODERATE = ("load.displacement=[1.0, 0.0]",)


def strategy_settings(quick: bool) -> Iterator[Setting]:
    """Both strategies over shear, pressure and stiffness of inclusions, on the 3x3 tissue, in four levels."""
    shears = (0.5,) if quick else (0.5, 0.25, 1.0)
    lumens: dict[str, tuple[str, ...]] = {"empty": ()}
    if not quick:
        lumens |= {f"pressure {p:g}": ('lumen.kind="pressure"', f"lumen.pressure={p}") for p in (0.01,)}
        lumens |= {
            f"inclusion {c:g}": (*LUMENS["filled"][:2], f"lumen.material.c1={c}", "lumen.material.c2=0.0",
                                 f"lumen.material.bulk_modulus={100 * c}")
            for c in (1e-3, 1e-1)
        }  # fmt: skip
    for shear, (name, lumen), strategy in product(shears, lumens.items(), ("sddp", "single-step")):
        overrides = (f"load.displacement=[{shear}, 0.0]", *lumen)
        problem = f"3x3 {name}, shear {shear:g}"
        yield Setting("tissue", problem, "penalty", 3, 0.5, "shear-empty-3x3", strategy, 4, overrides)
