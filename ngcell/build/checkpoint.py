"""A checkpoint: everything that the steps after an accepted one depend on, and nothing else.

A run that was stopped goes on from here as if it had not been. What terms and strategies remember of accepted steps is
in `memory`; see `ngcell.build.simulation`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.drive import Drive
from ngcell.results.measure import WorkPoint
from ngcell.results.onset import PairOnsets
from ngcell.results.rupture.cells import CellEnds
from ngcell.solve.strategies.strategy import Progress

Array = NDArray[np.float64]

_DISPLACEMENT, _WORK, _MEMORY, _COUNT, _ONSETS = "displacement_", "work_", "memory_", "count", "onsets"
_REPORTED, _LEVEL, _ENDS, _REACHED = "reported_", "level_", "ends", "reached"


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """Where a run is after an accepted step.

    Attributes
    ----------
    count : int
        Number of accepted steps.
    displacement : mapping of str to array of float, shape (unknowns,)
        That of the last accepted step, by phase [length].
    work : mapping of str to WorkPoint
        Where the work to the next step of a phase is reckoned from: an equilibrium; none before the first step where
        bodies at rest are in none.
    memory : mapping of str to array
        What terms remember, and where energy went.
    onsets : PairOnsets, optional
        Which wall pairs have opened, and where; None where curves start at the first level.
    reported : mapping of str to array of float
        Displacement of all unknowns of the last step of each phase, on the mesh that it was reported on [length].
    levels : mapping of str to int
        Number of that mesh.
    ends : CellEnds, optional
        How cells have ended so far, where it is known what walls bear and steps were accepted.
    reached : int
        Number of levels of the load that have been reached.
    """

    count: int = 0
    displacement: Mapping[str, Array] = field(default_factory=dict)
    work: Mapping[str, WorkPoint] = field(default_factory=dict)
    memory: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    onsets: PairOnsets | None = None
    reported: Mapping[str, Array] = field(default_factory=dict)
    levels: Mapping[str, int] = field(default_factory=dict)
    ends: CellEnds | None = None
    reached: int = 0

    @property
    def progress(self) -> Progress:
        """How far the load path has been followed."""
        load = self.work["released"].load_factor if "released" in self.work else 0.0
        return Progress(self.count, load, self.displacement, self.memory)

    def after(self, phase: str, displacement: Array, work: WorkPoint) -> Checkpoint:
        """Return the checkpoint after one more accepted step, with the displacement of all unknowns."""
        return replace(
            self,
            count=self.count + 1,
            reported={**self.reported, phase: displacement},
            work={**self.work, phase: work},
        )

    def on_level(self, phase: str, level: int) -> Checkpoint:
        """Return the checkpoint as a step on this mesh sees it: energies on another are no part of its work, but for
        that of bodies that have not moved."""
        is_same = self.levels.get(phase, level) == level or not np.any(self.reported.get(phase, 0.0))
        work = self.work if is_same else {name: point for name, point in self.work.items() if name != phase}
        return replace(self, work=work, levels={**self.levels, phase: level})

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return it as named arrays."""
        return {
            _COUNT: np.array(self.count),
            _REACHED: np.array(self.reached),
            **{f"{_DISPLACEMENT}{phase}": values for phase, values in self.displacement.items()},
            **{f"{_WORK}{phase}": _row(point) for phase, point in self.work.items()},
            **{f"{_MEMORY}{name}": values for name, values in self.memory.items()},
            **({} if self.onsets is None else {_ONSETS: self.onsets.array()}),
            **({} if self.ends is None else {_ENDS: self.ends.array()}),
            **{f"{_REPORTED}{phase}": values for phase, values in self.reported.items()},
            **{f"{_LEVEL}{phase}": np.array(level) for phase, level in self.levels.items()},
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], unknowns: int) -> Checkpoint:
        """Return what `arrays` was made of.

        Raises
        ------
        ValueError
            If it belongs to another number of unknowns.
        KeyError, TypeError
            If it is not what `arrays` returned.
        """

        def part(prefix: str) -> dict[str, NDArray[Any]]:
            return {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}

        displacement = {phase: np.asarray(values, dtype=float) for phase, values in part(_DISPLACEMENT).items()}
        sizes = {values.size for values in displacement.values()}
        if not sizes <= {unknowns}:
            raise ValueError(f"it holds {max(sizes)} unknowns where the case has {unknowns}")
        work = {phase: _point(values.tolist()) for phase, values in part(_WORK).items()}
        onsets = PairOnsets.from_array(arrays[_ONSETS]) if _ONSETS in arrays else None
        levels = {phase: int(level) for phase, level in part(_LEVEL).items()}
        ends = CellEnds.from_array(arrays[_ENDS]) if _ENDS in arrays else None
        count, reached = int(arrays[_COUNT]), int(arrays[_REACHED])
        return cls(count, displacement, work, part(_MEMORY), onsets, part(_REPORTED), levels, ends, reached)


def _row(point: WorkPoint) -> Array:
    drives = [number for drive in point.drives for number in astuple(drive)]
    return np.array([point.load_factor, point.energy, point.support_work_rate, *drives])


def _point(row: list[float]) -> WorkPoint:
    load_factor, energy, rate, *rest = row
    drives = tuple(Drive(*rest[at : at + 3]) for at in range(0, len(rest), 3))
    return WorkPoint(load_factor, energy, rate, drives)
