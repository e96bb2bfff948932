"""What a run tells of an accepted step at its end; unlike a measurement it can be written down and read again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ngcell.mechanics.report import Check
from ngcell.results.certificate import Certificate
from ngcell.results.finding import Finding
from ngcell.results.record import StepRecord


@dataclass(frozen=True)
class StepReport:
    """What the summary needs to know of an accepted step.

    Attributes
    ----------
    record : StepRecord
        The row of the history.
    certificate : Certificate
        The verdict.
    findings : tuple of Finding
        What the case expects at this level, beside what was measured.
    free_bodies : tuple of int
        Bodies held by nothing.
    unstored_work : float
        Work since the step before that is not stored [stress * length**2].
    debonding : dict of str to Any
        What has come apart; empty between levels.
    refused, cutbacks : int
        Trial steps of minimisations that were refused, and load steps that were halved.
    meshes : tuple of dict of str to int
        Order, grading, halvings and unknowns of the meshes that were used until then, the coarsest first.
    """

    record: StepRecord
    certificate: Certificate
    findings: tuple[Finding, ...]
    free_bodies: tuple[int, ...]
    unstored_work: float
    debonding: Mapping[str, Any]
    refused: int
    cutbacks: int
    meshes: tuple[Mapping[str, int], ...] = ()

    def plain(self) -> dict[str, Any]:
        """Return it as JSON can hold it."""
        return asdict(self)

    @classmethod
    def from_plain(cls, table: Mapping[str, Any]) -> StepReport:
        """Return what `plain` was made of.

        Raises
        ------
        KeyError, TypeError
            If it is not what `plain` returned.
        """
        return cls(
            record=StepRecord(**table["record"]),
            certificate=Certificate(tuple(Check(**check) for check in table["certificate"]["checks"])),
            findings=tuple(Finding(**finding) for finding in table["findings"]),
            free_bodies=tuple(table["free_bodies"]),
            unstored_work=table["unstored_work"],
            debonding=table["debonding"],
            refused=table["refused"],
            cutbacks=table["cutbacks"],
            meshes=tuple(table["meshes"]),
        )
