"""A recorded run takes what a script adds, as `simulate` does; its folder tells of it, and resuming asks for it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import ngsolve
import numpy as np
import pytest

import ngcell
from ngcell.errors import CaseError, OutputError
from ngcell.results.observables.observable import observed
from tests.run.test_resume import TISSUE, assert_same_numbers, rows
from tools.studies.numbers import with_tolerance

CASE = ("shear-empty-3x3", [*TISSUE, "expected=[]"])


def on_a_foundation(space: Any) -> ngcell.OwnEnergy:
    return ngcell.OwnEnergy(space, lambda u, mesh: 0.05 * (u[0] ** 2 + u[1] ** 2) * ngsolve.dx)


def additions() -> dict[str, Any]:
    return {
        "terms": [on_a_foundation],
        "observables": [ngcell.Rotation()],
        "strategy": ngcell.SingleStep(),
        "options": with_tolerance(10.0),
    }


def test_a_recorded_run_has_the_numbers_of_a_simulated_one_with_the_same_additions(tmp_path: Path) -> None:
    case = ngcell.read_case(*CASE)
    recording = ngcell.record(case, tmp_path / "out", **additions(), pictures=False)
    records = list(recording)
    steps = ngcell.simulate(case, **additions())
    assert [record.energy for record in records] == [step.record.energy for step in steps]
    usual = [step.record.energy for step in ngcell.simulate(case)]
    assert records[-1].energy > 1.01 * usual[-1]  # what the foundation stores
    assert [record.phase for record in records] == ["released", "released"]  # a single step has no tied ones
    assert "rotation" in rows(tmp_path / "out" / "history.csv")[0]
    assert not list((tmp_path / "out").glob("*.png"))
    text = (tmp_path / "out" / "case.toml").read_text()
    assert "# From a script: term = on_a_foundation\n" in text and "# From a script: strategy = SingleStep(" in text
    assert "# From a script: observable = Rotation(" in text and "# From a script: options = Options(" in text


def test_a_recorded_run_is_resumed_with_the_same_additions_and_with_no_others(tmp_path: Path) -> None:
    case = ngcell.read_case(*CASE)
    whole, out = tmp_path / "whole", tmp_path / "out"
    list(ngcell.record(case, whole, **additions(), pictures=False))
    stopped = iter(ngcell.record(case, out, **additions(), pictures=False))
    next(stopped)
    stopped.close()
    with pytest.raises(OutputError, match="its script had added .*term = on_a_foundation.*; now it adds nothing; hand"):
        ngcell.resume(out)
    with pytest.raises(OutputError, match="now it adds .*strategy = Sddp"):
        ngcell.resume(out, **{**additions(), "strategy": ngcell.Sddp(steps=3)})
    assert len(list(ngcell.resume(out, **additions(), pictures=False))) == 1
    assert_same_numbers(rows(out / "history.csv"), rows(whole / "history.csv"))


_TAKEN = "a column or a field has"


@pytest.mark.parametrize(
    ("names", "words"),
    [(("energy",), _TAKEN), (("J",), _TAKEN), (("free",), _TAKEN), (("mine", "mine"), "another observable has")],
)
def test_observables_have_names_of_their_own_before_anything_is_solved(names, words) -> None:
    observables = [SimpleNamespace(name=name, values=lambda view: 1.0) for name in names]
    with pytest.raises(CaseError, match=f"observable '{names[-1]}': {words} this name"):
        ngcell.simulate(ngcell.read_case("shear-empty-3x3"), observables=observables)


@pytest.mark.parametrize("name", [None, "", 3, "ngcell_verdict"])
def test_what_is_no_name_of_an_observable_is_told(name) -> None:
    with pytest.raises(CaseError, match="has the name .*; allowed: a text"):
        ngcell.simulate(ngcell.read_case("shear-empty-3x3"), observables=[SimpleNamespace(name=name, values=abs)])


@pytest.mark.parametrize("values", [None, "much", [1.0, 2.0], np.zeros((4, 2)), np.zeros(0)])
def test_what_an_observable_returns_is_a_number_or_one_a_body(values) -> None:
    view = SimpleNamespace(problem=SimpleNamespace(space=SimpleNamespace(body_count=4)))
    with pytest.raises(CaseError, match=r"'mine' returned .*; allowed: a number, or one a body, shape \(4,\)"):
        observed([SimpleNamespace(name="mine", values=lambda view: values)], view)
    for good, mean in ((2, 2.0), (np.arange(4), 1.5), ([1, 2, 3, 6], 3.0)):
        assert observed([SimpleNamespace(name="mine", values=lambda view, good=good: good)], view)[0] == {"mine": mean}
