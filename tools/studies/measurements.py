"""What `scaling` measures, each in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, process_time

import ngcell
from ngcell import Case
from tools.runs import ended
from tools.solutions import solved
from tools.studies.iterations import iterated, peak
from tools.studies.plain import one_body
from tools.studies.timed import Stopwatch, Timed


def tissue(rows: int, cols: int, *, order: int = 2, shear: float = 0.3) -> Case:
    """Return a tissue's case: its plates are moved along x by `shear` [length]."""
    sets = [f"tissue.rows={rows}", f"tissue.cols={cols}", f"mesh.order={order}", "load.levels=1"]
    case = ngcell.read_case("shear-empty", [*sets, f"load.displacement=[{shear}, 0.0]", "accuracy=inf"])
    assert isinstance(case, Case)
    return case


def growth(rows: int, cols: int) -> dict[str, float]:
    """Time iterations of a tissue of this size."""
    return iterated(tissue(rows, cols))


def contact_share(rows: int, cols: int) -> dict[str, float]:
    """Return what share of a run of the default tissue contact takes."""
    started, contact = process_time(), Stopwatch()
    case = tissue(rows, cols, order=3, shear=1.0)
    ngcell.simulate(case.model_copy(update={"contact": Timed(case.contact, contact)}))
    seconds = process_time() - started
    return {"seconds": seconds, "of contact": contact.seconds, "share": contact.seconds / seconds}


def seconds_of_help() -> dict[str, float]:
    """Return the smallest of five times that `ngcell --help` takes on the clock."""
    return {"seconds": min(ended("ngcell", "--help").clock for _ in range(5))}


def large() -> dict[str, float]:
    """Run 500 cells to a shear of a tenth of the height."""
    started = perf_counter(), process_time()
    height = 1.5 * 19 + 2
    solution = solved(tissue(20, 25, shear=0.1 * height))
    return {
        "unknowns": float(solution.unknowns),
        "minutes": (perf_counter() - started[0]) / 60,
        "processor minutes": (process_time() - started[1]) / 60,
        "GiB": peak() / 1024,
        "iterations": float(solution.iterations),
        "factorisations": float(solution.factorisations),
        "certified": float(solution.certified),
        **{f"{name} s": value for name, value in solution.seconds.items()},
    }


MEASUREMENTS: dict[str, Callable[[], dict[str, float]]] = {
    "help": seconds_of_help,
    "one body": one_body,
    "contact 3x3": lambda: contact_share(3, 3),
    "contact 5x7": lambda: contact_share(5, 7),
    "growth 3x3": lambda: growth(3, 3),
    "growth 10x10": lambda: growth(10, 10),
    "growth 30x30": lambda: growth(30, 30),
    "large": large,
}
