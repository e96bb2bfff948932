"""What a study will take, foreseen from the sizes of its cases and, where some of it has run, from what that took."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import ceil
from statistics import median
from time import perf_counter

from ngcell.build.discretisation import user_defined
from ngcell.build.foreseen import Foreseen, foreseen
from ngcell.build.stages import stages_of
from ngcell.errors import CaseError
from ngcell.scene import AnyCase, BodyCase

#: Meshes that most steps come to where errors are estimated: that of the load path, and two finer ones.
_USUAL = 3
#: Seconds of a level of nine cells of 144 unknowns each, how they grow with cells and with unknowns of each, and what a
#: run takes besides [s]. Measured on sheared tissues of 9 and 35 cells, of 1296 to 8640 unknowns: to 15 %.
_LEVEL, _CELLS, _OF_EACH, _WITH_CELLS, _WITH_UNKNOWNS, _START = 0.7, 9, 144, 1.45, 0.8, 1.5
#: Time after which further cases are taken for as large as those before them [s].
_PATIENCE = 5.0
#: Runs of a study in the store from which times are told.
_ENOUGH = 3


@dataclass(frozen=True)
class CaseCost:
    """What one run takes.

    Attributes
    ----------
    unknowns : float
        On the finest mesh that most runs come to.
    memory : float
        Memory [GiB].
    seconds : float
        Processor seconds [s].
    """

    unknowns: float
    memory: float
    seconds: float


def cost_of(case: AnyCase) -> CaseCost | None:
    """Return what a run of a case will take; None where its tissue does not tell its size."""
    finest = stages_of(case)[:_USUAL][-1].scene
    found = foreseen(user_defined(finest) if isinstance(finest, BodyCase) else finest)
    if found is None:
        return None
    return CaseCost(found.unknowns, found.memory, _seconds(found, _bodies(case), len(case.level_factors)))


def _seconds(found: Foreseen, bodies: int, levels: int) -> float:
    of_each = found.unknowns / bodies / _OF_EACH
    return float(_START + levels * _LEVEL * (bodies / _CELLS) ** _WITH_CELLS * of_each**_WITH_UNKNOWNS)


def _bodies(case: AnyCase) -> int:
    return len(case.bodies) if isinstance(case, BodyCase) else max(1, getattr(case.tissue, "cell_count", 1))


class Costs:
    """What the runs of a study will take, case by case.

    Attributes
    ----------
    seconds : list of float
        Foreseen processor seconds of each [s].
    largest : CaseCost
        The most unknowns, and the most memory.
    smallest_unknowns : float
        The fewest unknowns.
    """

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self.largest, self.smallest_unknowns = CaseCost(0.0, 0.0, 0.0), float("inf")
        self._spent, self._looked_at, self._sum = 0.0, 0, 0.0

    def add(self, case: AnyCase) -> None:
        """Look at a further case; where looking takes long, as at many drawn tissues, it is taken for a usual one."""
        cost = None
        if self._spent < _PATIENCE:
            started = perf_counter()
            with suppress(CaseError):  # bodies that have no size: their run tells it
                cost = cost_of(case)
            self._spent += perf_counter() - started
        if cost is not None:
            self._note(cost)
        self.seconds.append(self._mean if cost is None else cost.seconds)

    def skip(self) -> None:
        """Count a case that is none."""
        self.seconds.append(0.0)

    @property
    def _mean(self) -> float:
        return self._sum / self._looked_at if self._looked_at else 1.0

    def _note(self, cost: CaseCost) -> None:
        self._looked_at, self._sum = self._looked_at + 1, self._sum + cost.seconds
        self.smallest_unknowns = min(self.smallest_unknowns, cost.unknowns)
        most = (max(getattr(one, name) for one in (self.largest, cost)) for name in ("unknowns", "memory", "seconds"))
        self.largest = CaseCost(*most)


@dataclass(frozen=True)
class Outlook:
    """What is left of a study.

    Attributes
    ----------
    cases, refused, missing : int
        All cases, those that are none, and those that have to be run.
    unknowns : tuple of float
        The fewest and the most of a case; zeros where no tissue tells.
    memory : float
        The most of a case [GiB].
    seconds : float
        Processor seconds of all that are missing [s].
    measured : int
        Number of runs in the store that the seconds are told from; 0 where they are those of other tissues.
    """

    cases: int
    refused: int
    missing: int
    unknowns: tuple[float, float]
    memory: float
    seconds: float
    measured: int

    def hours(self, workers: int) -> float:
        """Return the time on the clock with so many workers [h]: no run is shared between two."""
        alone = self.seconds / max(1, self.missing)
        return ceil(self.missing / workers) * alone / 3600


def outlook(costs: Costs, missing: Sequence[int], refused: int, measured: Sequence[tuple[int, float]]) -> Outlook:
    """Return what is left of a study.

    Parameters
    ----------
    costs : Costs
        Those of all cases.
    missing : sequence of int
        Numbers of the cases that have to be run.
    refused : int
        Number of those that are none.
    measured : sequence of (int, float)
        Number and seconds of runs that have ended.
    """
    ratios = [seconds / costs.seconds[number] for number, seconds in measured if costs.seconds[number] > 0]
    factor = median(ratios) if len(ratios) >= _ENOUGH else 1.0
    known = costs.largest.unknowns > 0
    return Outlook(
        cases=len(costs.seconds),
        refused=refused,
        missing=len(missing),
        unknowns=(costs.smallest_unknowns, costs.largest.unknowns) if known else (0.0, 0.0),
        memory=costs.largest.memory,
        seconds=factor * sum(costs.seconds[number] for number in missing),
        measured=len(ratios) if len(ratios) >= _ENOUGH else 0,
    )

