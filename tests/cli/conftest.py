"""A stand-in for the simulation: it accepts steps without solving anything, and writes them in earnest."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import ngcell
from ngcell.results.record import StepRecord
from ngcell.scene import Case, resolved_toml


def accepted_step(step: int, load_factor: float, *, certified: bool = True) -> StepRecord:
    return StepRecord(
        step=step,
        phase="released",
        load_factor=load_factor,
        plate_displacement=load_factor,
        largest_gap=0.01 * step,
        mean_gap=0.001 * step,
        smallest_gap=0.0,
        parted_pairs=step,
        opened_share=0.0,
        components=1,
        largest_component=4,
        plate_force_x=0.1,
        plate_force_y=0.0,
        contact_force=0.2,
        energy=0.3,
        iterations=4,
        factorisations=4,
        seconds=0.5,
        certified=certified,
    )


@dataclass
class FakeRun:
    """What the stand-in answers, and what it was asked.

    Parameters
    ----------
    certified : bool
        The verdict.
    stop_after : int, optional
        Number of accepted steps after which `error` is raised.
    error : BaseException, optional
        What ends the continuation early.
    """

    certified: bool = True
    stop_after: int | None = None
    error: BaseException | None = None
    asked: list[tuple[Case, Path, int | None]] = field(default_factory=list)

    def record(
        self, case: Case, out: Path, *, threads: int | None = None, force: bool = False, **how: object
    ) -> FakeRecording:
        self.asked.append((case, out, threads))
        return FakeRecording(self, case, out, force)

    def inspect(self, case: Case) -> dict[str, Any]:
        if self.error:
            raise self.error
        return {"bodies": case.tissue.cell_count, "unknowns": 4800, "initial_gap": {"smallest": 0.0}}


@dataclass
class FakeRecording:
    run: FakeRun
    case: Case
    out: Path
    force: bool = False
    outcome: str = "converged"
    accepted_before: tuple[StepRecord, ...] = ()

    @property
    def level_factors(self) -> tuple[float, ...]:
        return self.case.load.level_factors

    @property
    def certified(self) -> bool:
        return self.run.certified

    @property
    def summary(self) -> dict[str, Any]:
        record, certified = accepted_step(4, 1.0, certified=self.certified), self.certified
        check = {"worst": 1.25e-12 if certified else 1e-3, "limit": 1e-6, "passed": certified}
        return {
            "certified": certified,
            "outcome": self.outcome,
            "accepted_steps": 5,
            "certificate": {"residual": check},
            "failed_steps": {} if certified else {4: ["residual"]},
            "bodies": 9,
            "facing_pairs": 16,
            "debonding": {"wall_pairs_opened": 7, "wall_pairs_parted": 4, "component_sizes": [8, 1]},
            "held_by_nothing": [5, 7],
            "onset_of_growth": 0.2,
            "last_step": asdict(replace(record, energy_error=0.003)),
            "seconds": {"on_the_clock": 150.0},
        }

    def __iter__(self) -> Iterator[StepRecord]:
        from ngcell.export import ResultFolder

        with ResultFolder(self.out, case_text=resolved_toml(self.case), force=self.force) as folder:
            for step, factor in enumerate(self.case.load.level_factors):
                if self.run.error and step == self.run.stop_after:
                    raise self.run.error
                record = accepted_step(step, factor, certified=self.certified)
                folder.accept(record)
                yield record
            folder.finish({"certified": self.certified, **self.summary})


@pytest.fixture
def fake_run(monkeypatch: pytest.MonkeyPatch) -> FakeRun:
    """Put the stand-in where the command line looks for `ngcell.run`."""
    fake = FakeRun()
    module = ModuleType("ngcell.run")
    module.record, module.inspect = fake.record, fake.inspect  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ngcell.run", module)
    monkeypatch.setattr(ngcell, "run", module, raising=False)
    return fake


@pytest.fixture
def in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path
