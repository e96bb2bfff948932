"""The rows of the table: what each program found, beside what is right."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any

from tools.references.peers import calculix, here, with_getfem
from tools.references.peers.answer import Answer
from tools.references.peers.problems import Problem, exact_force, problem

COLUMNS = (
    "problem",
    "program",
    "order",
    "elements across",
    "force",
    "error",
    "opening",
    "opening error",
    "seconds",
    "unknowns",
)
#: Columns that say which run a row is of.
KEY = COLUMNS[:4]
PROBLEMS, ORDERS = ("blocks", "rings", "cells"), (1, 2)
#: What is taken for right about the cells, and a run that says how well it is known: contact method, elements across,
#: order, and how often elements are halved where stresses are singular.
REFERENCE, OTHERWISE = "reference", "reference, by penalty, finer"
REFERENCES = {REFERENCE: ("mortar", 2, 4, 1), OTHERWISE: ("penalty", 2, 4, 2)}
#: Seconds after which these are stopped.
PATIENCE = 900
Solve = Callable[[Problem, int], Answer]
Row = dict[str, Any]


def programs() -> Iterator[tuple[str, Solve, tuple[int, ...]]]:
    """Yield each program that is here, how it solves, and its orders."""
    for name, peer in (("CalculiX", calculix), ("GetFEM", with_getfem)):
        if not peer.missing():
            yield name, peer.solve, ORDERS
    for method in here.METHODS:
        yield f"ngcell {method}", partial(here.solve, method), (*ORDERS, 3)


def missing() -> list[str]:
    """Return what is not installed here, in words."""
    return [line for line in (calculix.missing(), with_getfem.missing()) if line]


def runs(name: str, counts: Sequence[int]) -> Iterator[Row]:
    """Yield a row for each program that is here, order, and number of elements across."""
    for program, solve, orders in programs():
        for order, count in product(orders, counts):
            yield _row(name, program, order, count, partial(solve, problem(name, count), order))


def references() -> Iterator[Row]:
    """Yield the rows of what is taken for right about the cells."""
    for program, (method, count, order, grades) in REFERENCES.items():
        solve = partial(here.solve, method, problem("cells", count), order, grades=grades, limit=PATIENCE)
        yield _row("cells", program, order, count, solve)


def _row(name: str, program: str, order: int, count: int, solve: Callable[[], Answer]) -> Row:
    """Return the row of a run; instead of an error it says why there is no answer."""
    row: Row = dict.fromkeys(COLUMNS, "") | dict(zip(KEY, (name, program, str(order), str(count)), strict=True))
    try:
        found = solve()
    except RuntimeError as error:
        return row | {"error": str(error)}
    opening = "" if found.opening is None else f"{found.opening:.6g}"
    row |= {"force": repr(found.force), "opening": opening}
    return row | {"seconds": f"{found.seconds:.2f}", "unknowns": str(found.unknowns)}


def judged(rows: Iterable[Row]) -> list[Row]:
    """Return rows with their errors, relative to what is right."""
    rows = list(rows)
    reference = next((row for row in rows if row["program"] == REFERENCE), {})
    return [row | _errors(row, reference) for row in rows]


def _errors(row: Row, reference: Row) -> Row:
    """Return the errors of a row; none of the reference, nor where there is nothing to compare with."""
    force, opening = _numbers(row)
    if row["problem"] == "cells":
        exact, parted = _numbers({} if row["program"] == REFERENCE else reference)
    else:
        exact, parted = exact_force(row["problem"], in_logarithm=row["program"].startswith("ngcell")), None
    error = row["error"] if force is None else _error(force, exact)
    return {"error": error, "opening error": _error(opening, parted)}


def _numbers(row: Row) -> tuple[float | None, float | None]:
    """Return force and opening of a row, where it has them."""
    force, opening = (float(row[name]) if row.get(name) else None for name in ("force", "opening"))
    return force, opening


def _error(found: float | None, right: float | None) -> str:
    return "" if found is None or right is None else f"{abs(found / right - 1):.1e}"


def merged(kept: Iterable[Row], new: Iterable[Row]) -> list[Row]:
    """Return rows in order; new ones in place of those of the same runs."""
    by_run = {tuple(row[name] for name in KEY): row for row in (*kept, *new)}
    known = [*REFERENCES, "CalculiX", "GetFEM", *(f"ngcell {method}" for method in here.METHODS)]
    at = {name: number for number, name in enumerate((*PROBLEMS, *known))}
    return [by_run[key] for key in sorted(by_run, key=lambda key: (at[key[0]], at[key[1]], int(key[2]), int(key[3])))]
