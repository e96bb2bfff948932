"""An accepted step with everything that is reported of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.build.checkpoint import Checkpoint
from ngcell.results.cells import debonding
from ngcell.results.finding import Finding
from ngcell.results.measure import Measurement
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.report import StepReport
from ngcell.results.snapshot import Snapshot
from ngcell.solve.effort import Effort


@dataclass(frozen=True)
class Mesh:
    """How finely bodies are resolved.

    Attributes
    ----------
    order, grading, halvings, unknowns : int
        Order of the elements, how often they are graded towards corners and halved along walls, and number of
        displacement unknowns.
    """

    order: int
    grading: int
    halvings: int
    unknowns: int


@dataclass(frozen=True, eq=False)
class Step:
    """An accepted step with everything that is reported of it.

    Attributes
    ----------
    record : StepRecord
        The row of the history.
    walls : list of WallRecord
        A row a facing pair; empty in tied steps.
    cells : list of CellRecord
        A row a cell; empty in tied steps.
    measurement : Measurement
        The numbers behind them.
    displacement : array of float, shape (unknowns,)
        The displacement [length].
    snapshot : Snapshot or None
        The fields, at reported levels.
    findings : list of Finding
        What the case expects at this level, beside what was measured.
    checkpoint : Checkpoint
        Where the load path stands after it.
    effort : Effort
        What it took.
    mesh : Mesh
        The mesh that its numbers are of.
    meshes : tuple of dict of str to int
        All that were used until then; see `ngcell.results.report.StepReport`.
    """

    record: StepRecord
    walls: list[WallRecord]
    cells: list[CellRecord]
    measurement: Measurement
    displacement: NDArray[np.float64]
    snapshot: Snapshot | None
    findings: list[Finding]
    checkpoint: Checkpoint
    effort: Effort
    mesh: Mesh
    meshes: tuple[Mapping[str, int], ...] = ()

    @property
    def report(self) -> StepReport:
        """What the summary needs to know of it."""
        measured = self.measurement
        return StepReport(
            self.record,
            measured.certificate,
            tuple(self.findings),
            measured.free_bodies,
            measured.unstored_work,
            debonding(self.walls, self.cells),
            self.effort.refusals,
            self.effort.cutbacks,
            self.meshes,
        )
