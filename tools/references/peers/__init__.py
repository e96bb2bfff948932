"""Blocks and rings by other programs that are installed, beside this package: errors and seconds.

    python -m tools.references peers            all programs that are here, into tools/results

CalculiX has quadratic hexahedra (linear ones at order 1) and a penalty 30 times as stiff as a layer of elements, GetFEM
quadratic or linear quadrilaterals and an augmented Lagrangian, this package triangles and penalties 100 times as stiff.
Sizes of elements are the same. Errors are those of the force that blocks, or the outer ring, bear, by the volumetric
energy of each program. Seconds are those on the clock of one run on one thread, without the start of this package, with
that of the others. What is not installed is named, and left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.references.peers import calculix, here, with_getfem
from tools.references.peers.problems import KAPPA, exact_force

COLUMNS = ("problem", "program", "order", "elements across", "error", "seconds", "unknowns")
#: Elements across the first body, and orders.
COUNTS, ORDERS = (2, 4, 8), (1, 2)
Solve = Callable[[str, int, int], tuple[float, float, int]]


def programs() -> Iterator[tuple[str, Solve, bool, tuple[int, ...]]]:
    """Yield each program that is here, how it solves, whether its law is in ln J, and its orders."""
    for name, peer in (("CalculiX", calculix), ("GetFEM", with_getfem)):
        if not peer.missing():
            yield name, peer.force, False, ORDERS
    for method in here.METHODS:
        yield f"ngcell {method}", partial(here.force, method), True, (*ORDERS, 3)


def missing() -> list[str]:
    """Return what is not installed here, in words."""
    return [line for line in (calculix.missing(), with_getfem.missing()) if line]


@described(__doc__)
@click.option("--count", "counts", type=int, multiple=True, default=COUNTS, help="Elements across the first body.")
def command(counts: tuple[int, ...]) -> None:
    """Solve all problems by all programs and write the tables."""
    for line in missing():
        click.echo(f"{line}; its lines are left out", err=True)
    rows = []
    for problem, (program, solve, in_logarithm, orders) in product(KAPPA, programs()):
        for order, count in product(orders, counts):
            rows.append(dict(zip(COLUMNS, (problem, program, order, count), strict=False)))
            try:
                force, seconds, unknowns = solve(problem, count, order)
            except RuntimeError as error:
                rows[-1]["error"] = str(error)
            else:
                wrong = abs(force / exact_force(problem, in_logarithm=in_logarithm) - 1)
                rows[-1] |= {"error": f"{wrong:.1e}", "seconds": f"{seconds:.2f}", "unknowns": unknowns}
            click.echo(", ".join(map(str, rows[-1].values())), err=True)
    tables.write(RESULTS / "peers.csv", COLUMNS, rows)
    text = f"# Blocks and rings by other programs\n\n{(__doc__ or '').splitlines()[0]}\n\n"
    text += tables.markdown(COLUMNS, ([row.get(name, "") for name in COLUMNS] for row in rows))
    (RESULTS / "peers.md").write_text(text + "\n", encoding="utf-8")
