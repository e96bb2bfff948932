"""Where a continuation stands after an accepted step: everything that later steps depend on, and nothing else.

A run that was stopped goes on from here as if it had not been. Whatever a later step is to know of an earlier one has
its place here: a term of the energy with a memory, that of an irreversible law for example, puts its arrays into
`memory` when a step is accepted and is given them back when a continuation is resumed; see `Simulation.continuation`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.results.measure import WorkPoint
from ngcell.results.onset import PairOnsets

Array = NDArray[np.float64]

_DISPLACEMENT, _WORK, _MEMORY, _COUNT, _ONSETS = "displacement_", "work_", "memory_", "count", "onsets"


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """Where a continuation stands.

    Attributes
    ----------
    count : int
        Number of accepted steps.
    displacement : mapping of str to array of float, shape (unknowns,)
        That of the last accepted step, by phase [length].
    work : mapping of str to WorkPoint
        Where the work to the next step of a phase is reckoned from.
    memory : mapping of str to array
        What terms of the energy remember.
    onsets : PairOnsets, optional
        Which wall pairs have opened, and where; None before the first level.
    """

    count: int = 0
    displacement: Mapping[str, Array] = field(default_factory=dict)
    work: Mapping[str, WorkPoint] = field(default_factory=dict)
    memory: Mapping[str, Array] = field(default_factory=dict)
    onsets: PairOnsets | None = None

    def after(
        self, phase: str, displacement: Array, work: WorkPoint, memory: Mapping[str, Array] | None = None
    ) -> Checkpoint:
        """Return where the continuation stands after one more accepted step."""
        return replace(
            self,
            count=self.count + 1,
            displacement={**self.displacement, phase: displacement},
            work={**self.work, phase: work},
            memory=self.memory if memory is None else memory,
        )

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """Return it as named arrays."""
        return {
            _COUNT: np.array(self.count),
            **{f"{_DISPLACEMENT}{phase}": values for phase, values in self.displacement.items()},
            **{f"{_WORK}{phase}": np.array(astuple(point)) for phase, point in self.work.items()},
            **{f"{_MEMORY}{name}": values for name, values in self.memory.items()},
            **({} if self.onsets is None else {_ONSETS: self.onsets.array()}),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], unknowns: int) -> Checkpoint:
        """Return what `arrays` was made of.

        Raises
        ------
        ValueError
            If it belongs to another number of unknowns.
        KeyError, TypeError
            If it is not what `arrays` returned.
        """

        def part(prefix: str) -> dict[str, NDArray[np.generic]]:
            return {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}

        displacement = {phase: np.asarray(values, dtype=float) for phase, values in part(_DISPLACEMENT).items()}
        sizes = {values.size for values in displacement.values()}
        if not sizes <= {unknowns}:
            raise ValueError(f"it holds {max(sizes)} unknowns where the case has {unknowns}")
        work = {phase: WorkPoint(*values.tolist()) for phase, values in part(_WORK).items()}
        onsets = PairOnsets.from_array(arrays[_ONSETS]) if _ONSETS in arrays else None
        return cls(int(arrays[_COUNT]), displacement, work, part(_MEMORY), onsets)
