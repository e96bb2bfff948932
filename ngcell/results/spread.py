"""How much of a number is known: its mean and spread over members of a case, whose geometries differ a little.

The estimated error is that of one equilibrium. Which equilibrium walls find may depend on the smallest change of the
geometry; then members scatter by far more than the mesh explains, and more than the geometry itself does. Numbers that
follow the geometry smoothly change by a few times the share by which it varies at most: the bending stiffness of a
wall, the most sensitive of them, goes with the cube of thickness over length. With corners displaced evenly over a disc
of this radius the lengths of sides have a standard deviation of the share over ``sqrt(2)``, and thicknesses that are
distributed evenly one of it over ``sqrt(3)``. Gaps follow the places of corners besides, by the share of a side over
``sqrt(2)``. Numbers of many walls scatter by less.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, isclose, isfinite, nan, sqrt

import numpy as np

from ngcell.results.record import StepRecord

#: A spread of more than so many estimated errors is not one of the mesh.
BEYOND_ERROR = 3.0
#: Most that a number scatters by as it follows the geometry, as a multiple of the share by which that varies.
SMOOTH = 3 * sqrt(1 / 2 + 1 / 3)
#: Numbers of a step, in the order of the tables; those with an error have it in the column after.
_FIELDS = (
    "energy", "plate_force_x", "plate_force_y", "plate_force_z", "contact_force", "mean_gap", "largest_gap",
    "smallest_gap", "free_mean_gap", "free_largest_gap", "opened_share", "parted_pairs", "components",
    "largest_component", "separation_energy", "bonded_share", "dissipation",
)  # fmt: skip
#: How the outcome of a member begins whose geometry cannot be built.
REFUSED = "refused"
_BRANCHES, _GEOMETRY = "neighbouring geometries end on other branches", "it follows the geometry"


@dataclass(frozen=True)
class Member:
    """One member of a case, after its run.

    Attributes
    ----------
    number, seed : int
        Its number, from 0, and the seed of its geometry.
    outcome : str
        How its run ended, in words.
    certified : bool
        Whether it reached the last level and passed every check.
    levels : tuple of StepRecord or None
        Its released step at each level; None where it did not get there.
    """

    number: int
    seed: int
    outcome: str
    certified: bool
    levels: tuple[StepRecord | None, ...]

    @property
    def is_refused(self) -> bool:
        """Whether its geometry could not be built, so that nothing was run."""
        return self.outcome.startswith(REFUSED)


@dataclass(frozen=True, slots=True)
class Spread:
    """One number at one level, over the members that are certified there: a row of `spread.csv`.

    Attributes
    ----------
    level : int
        Number of the level, from 0.
    load_factor : float
        Share of the full load, in [0, 1].
    number : str
        Its name, as in `history.csv`; `plate_force` is the size of the vector.
    members : int
        Number of members that count.
    mean, deviation, smallest, largest : float
        Mean, standard deviation (of a sample), smallest and largest value; NaN where too few members count.
    error : float
        Mean of the estimated errors, in the unit of the number; NaN where none was estimated.
    known_to : float
        Standard deviation or estimated error, whichever is larger, over the mean; NaN where the mean is 0.
    remark : str
        Why no more than that is known, where members scatter by more than three estimated errors.
    """

    level: int
    load_factor: float
    number: str
    members: int
    mean: float
    deviation: float
    smallest: float
    largest: float
    error: float = nan
    known_to: float = nan
    remark: str = ""

    @property
    def relative(self) -> float:
        """Standard deviation over the size of the mean; NaN where that is 0."""
        return self.deviation / abs(self.mean) if self.mean else nan


def at_levels(history: Sequence[StepRecord], factors: Sequence[float]) -> tuple[StepRecord | None, ...]:
    """Return the released step of a run at each level of its load path; None where it did not get there.

    A load path may meet a load factor more than once: levels are found in the order of the steps.
    """
    found: list[StepRecord | None] = []
    for record in history:
        if record.phase == "released" and len(found) < len(factors) and isclose(
            record.load_factor, factors[len(found)], rel_tol=1e-5, abs_tol=1e-8
        ):
            found.append(record)
    return tuple(found) + (None,) * (len(factors) - len(found))


def numbers_of(record: StepRecord) -> dict[str, float]:
    """Return the numbers of a step that are compared, by name."""
    numbers = {name: float(getattr(record, name)) for name in _FIELDS}
    force = hypot(record.plate_force_x, record.plate_force_y, record.plate_force_z)
    return {"energy": numbers.pop("energy"), "plate_force": force, **numbers, **record.more}


def errors_of(record: StepRecord) -> dict[str, float]:
    """Return the estimated errors of these numbers; those without are left out."""
    force = dict.fromkeys((f"plate_force_{axis}" for axis in "xyz"), record.plate_force_error)
    same = ("energy", "plate_force", "contact_force", "mean_gap", "largest_gap")
    return {**{name: float(getattr(record, f"{name}_error")) for name in same}, **force}


def spreads(members: Sequence[Member], factors: Sequence[float], share: float, side: float) -> list[Spread]:
    """Return mean and spread of each number at each level.

    Parameters
    ----------
    members : sequence of Member
        All that have run; at each level those count that are certified there.
    factors : sequence of float
        Load factors of the levels.
    share : float
        Share of a side, or of the thickness, by which geometries differ at most; infinite where it is not known.
    side : float
        Side of the cells [length].
    """
    found = []
    for level, factor in enumerate(factors):
        records = [record for member in members if (record := member.levels[level]) and record.certified]
        for name in numbers_of(records[0]) if records else ():
            found.append(_spread(level, factor, name, records, share, side))
    return found


def _spread(
    level: int, factor: float, name: str, records: Sequence[StepRecord], share: float, side: float
) -> Spread:
    values = np.array([numbers_of(record).get(name, nan) for record in records])
    error = float(np.mean([errors_of(record).get(name, nan) for record in records]))
    mean, deviation = float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else nan
    known_to = max((one for one in (deviation, error) if isfinite(one)), default=nan) / abs(mean) if mean else nan
    remark = ""
    if isfinite(error) and deviation > BEYOND_ERROR * error:
        size = "plate_force" if name.startswith("plate_force") else name  # a part of a vector may vanish
        scale = abs(float(np.mean([numbers_of(record)[size] for record in records])))
        smooth = share * (SMOOTH * scale + (side / sqrt(2) if name.endswith("gap") else 0.0))
        remark = _BRANCHES if deviation > smooth else _GEOMETRY
    smallest, largest = float(values.min()), float(values.max())
    return Spread(level, factor, name, len(values), mean, deviation, smallest, largest, error, known_to, remark)
