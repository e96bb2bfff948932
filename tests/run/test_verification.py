"""What a stiffer penalty or a finer mesh moves, as a run reports it."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf
from pathlib import Path
from typing import Any

import pytest

from ngcell import BodyCase, Case, NormalLaw, Plates, read_case, record
from ngcell import recording as recording_module
from ngcell.build.additions import Additions
from ngcell.build.simulation import Simulation
from ngcell.build.verification import stiffer_result
from ngcell.cli.summary import summary_lines
from ngcell.clock import Clock
from ngcell.errors import CaseError, TooLarge
from ngcell.report.view import told_numbers
from ngcell.results.record import StepRecord
from ngcell.scene import AnyCase, BodyScene
from ngcell.scene.mesh import MeshChoice
from ngcell.solve.outcome import Outcome
from ngcell.solve.step import StepFailed


def sheared_pair(contact: str) -> Case:
    return Case.model_validate(
        {
            "tissue": {"rows": 2, "cols": 2, "wall": 0.1},
            "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
            "load": {"kind": "plates", "displacement": [0.4, -0.02], "levels": 2},
            "strategy": {"kind": "single-step"},
            "contact": {"kind": contact},
            "mesh": {"order": 2},
            "accuracy": inf,
        }
    )


def test_a_stiffer_penalty_moves_the_result_a_little_and_halves_the_overlap_at_least(tmp_path: Path) -> None:
    recording = record(sheared_pair("penalty"), tmp_path / "out", verify_penalty=True)
    steps = list(recording)
    table = recording.summary["stiffer_penalty"]
    assert table["stiffness_factor"] == 10
    assert table["energy"]["meant"] == steps[-1].energy
    assert 0 < table["energy"]["change"] < 0.02
    assert table["penetration_over_wall"]["change"] < -0.4
    shown = "\n".join(summary_lines(recording, tmp_path))
    assert "penalty terms 10 times as stiff" in shown and "penetration over wall" in shown


class OwnLoad:
    """A load of a script, which has no list of levels that a case could change."""

    supported, moved, level_factors = "plates", "upper-plate", (0.5, 1.0)
    plates = Plates(displacement=(0.1, 0.0))

    def motion(self, space):
        return self.plates.motion(space)

    def prescribed_displacement(self, space):
        return self.plates.prescribed_displacement(space)

    def tractions(self):
        return ()


def test_a_load_of_a_script_is_verified_along_all_of_its_levels(tmp_path: Path) -> None:
    case = sheared_pair("penalty").model_copy(update={"load": OwnLoad()})
    recording = record(case, tmp_path / "out", verify_penalty=True)
    steps = list(recording)
    assert recording.summary["stiffer_penalty"]["energy"]["meant"] == steps[-1].energy


def test_without_being_asked_a_run_solves_each_level_once(tmp_path: Path) -> None:
    recording = record(sheared_pair("penalty"), tmp_path / "out")
    assert len(list(recording)) == 2
    assert "stiffer_penalty" not in recording.summary


def test_the_mortar_method_has_no_penalty_to_verify(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no penalty to verify"):
        record(sheared_pair("mortar"), tmp_path / "out", verify_penalty=True)


def test_a_law_of_a_script_has_no_penalty_to_verify(tmp_path: Path) -> None:
    contact = NormalLaw(lambda gap, stiffness: (gap, gap, gap))
    with pytest.raises(CaseError, match="'NormalLaw' has no penalty to verify"):
        record(sheared_pair("penalty").model_copy(update={"contact": contact}), tmp_path / "out", verify_penalty=True)


def test_a_verification_that_cannot_be_made_leaves_the_run_as_it_ended(tmp_path: Path, monkeypatch) -> None:
    def too_large(*_: Any, **__: Any) -> None:
        raise TooLarge("the finer mesh takes 99 GiB; allowed: 1 GiB")

    monkeypatch.setattr(recording_module, "finer_result", too_large)
    recording = record(sheared_pair("penalty"), tmp_path / "out", verify_mesh=True)
    assert len(list(recording)) == 2 and recording.certified
    assert recording.summary["finer_mesh"] == {"failed": "the finer mesh takes 99 GiB; allowed: 1 GiB"}
    assert "99 GiB" in "\n".join(summary_lines(recording, tmp_path))


def test_where_penalty_terms_were_raised_the_stiffer_ones_are_stiffer_than_these(tmp_path: Path) -> None:
    """Blocks between walls that hold them: penalty terms yield as well, and the force is low by their share."""
    held = [{"boundary": f"{body}_{side}", "components": "x"} for body in ("base", "top") for side in ("left", "right")]
    material = {"kind": "mooney-rivlin", "c1": 0.5, "c2": 0.5, "bulk_modulus": 20.0}
    blocks = [
        {"name": name, "kind": "block", "low": [0.0, low], "high": [1.0, low + 1], "size": 0.5, "material": material}
        for name, low in (("base", 0.0), ("top", 1.0))
    ]
    ends = [{"boundary": "base_bottom"}, {"boundary": "top_top", "translation": [0.0, -0.05]}]
    case = {"levels": 1, "bodies": blocks, "supports": [*held, *ends], "mesh": {"order": 2}, "accuracy": inf}

    def run(kind: str):
        scene = BodyCase.model_validate({**case, "contact": {"kind": kind}})
        recording = record(scene, tmp_path / kind, verify_penalty=kind == "penalty")
        (step,) = recording
        return step, recording.summary

    (exact, _), (soft, summary) = run("mortar"), run("penalty")
    error = soft.contact_force / exact.contact_force - 1
    assert -0.01 < error < -0.001
    assert summary["stiffer_penalty"]["contact_force"]["change"] == pytest.approx(-0.9 * error, rel=0.03)


BONDED = (
    "tissue.rows=1", "tissue.cols=2", "load.displacement=[0.2, 0.0]", "load.levels=2", "cohesion.strength=0.0125",
    "cohesion.energy=0.000375",
)  # fmt: skip


def bonded(order: int) -> Case:
    case = read_case("shear-cohesive", [*BONDED, f"mesh.order={order}"])
    assert isinstance(case, Case)
    return case


def last(case: Case, out: Path, **options: bool) -> tuple[StepRecord, dict[str, Any]]:
    recording = record(case, out, pictures=False, **options)
    *_, step = recording
    return step, recording.summary


def test_one_order_more_tells_how_far_bonded_cells_are_from_a_much_finer_mesh(tmp_path: Path) -> None:
    """Of bonds, which remember their way, nothing else tells an error."""
    coarse, summary = last(bonded(2), tmp_path / "coarse", verify_mesh=True)
    fine, _ = last(bonded(5), tmp_path / "fine")
    table = summary["finer_mesh"]
    assert table["order"] == 3 and table["parted_pairs"]["meant"] == coarse.parted_pairs
    names = ("energy", "mean_gap", "separation_energy")
    found = {name: abs(getattr(coarse, name) - getattr(fine, name)) for name in names}
    off = hypot(coarse.plate_force_x - fine.plate_force_x, coarse.plate_force_y - fine.plate_force_y)
    for name, error in {**found, "plate_force": off}.items():
        assert table[name]["error"] > 0.8 * error, name
        assert name == "mean_gap" or table[name]["error"] < 3 * error, name  # which errs by hardly anything, by chance
    assert table["plate_force"]["meant"] == pytest.approx(hypot(coarse.plate_force_x, coarse.plate_force_y))


def test_errors_that_a_finer_mesh_tells_stand_beside_the_numbers(tmp_path: Path) -> None:
    recording = record(bonded(1), tmp_path / "out", pictures=False, verify_mesh=True)
    assert list(recording)
    table = recording.summary["finer_mesh"]
    shown = list(summary_lines(recording, tmp_path))
    (how,) = (line for line in shown if line.startswith("how sure"))
    assert how.endswith("with errors that elements of order 2 tell")
    (gap,) = (line for line in shown if line.startswith("  mean gap  ") and "%" in line)
    assert f"± {100 * table['mean_gap']['error'] / table['mean_gap']['meant']:.0f} %" in gap
    assert any(line.startswith("mesh         the last level with elements of order 2") for line in shown)


def test_hollow_cells_are_solved_again_at_the_last_level_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Levels of a tissue do not depend on each other."""
    case = sheared_pair("penalty")
    solved: list[AnyCase | BodyScene] = []

    def noted(self: Additions, scene: AnyCase | BodyScene, clock: Clock | None = None) -> Simulation:
        solved.append(scene)
        return Simulation(scene, clock)

    monkeypatch.setattr(Additions, "simulation", noted)
    _, summary = last(case, tmp_path / "out", verify_mesh=True)
    assert [len(scene.level_factors) for scene in solved] == [2, 1]
    assert summary["finer_mesh"]["order"] == 3 and "separation_energy" not in summary["finer_mesh"]
    assert 0 < summary["finer_mesh"]["energy"]["error"] < 0.5 * summary["finer_mesh"]["energy"]["meant"]


def test_where_errors_are_estimated_the_last_level_goes_on_to_the_finest_mesh(tmp_path: Path) -> None:
    """What that changes is within what was told, and stands beside it; the run stays as it is."""
    mesh = MeshChoice(grading=1)
    case = sheared_pair("penalty").model_copy(update={"accuracy": 0.1, "mesh": mesh})
    plain, _ = last(case, tmp_path / "plain")
    recording = record(case, tmp_path / "out", pictures=False, verify_mesh=True)
    *_, step = recording
    assert step == replace(plain, seconds=step.seconds)
    table = recording.summary["finer_mesh"]
    assert table["order"] == 6 and table["unknowns"] > recording.summary["unknowns"]
    for name in ("energy", "mean_gap", "plate_force"):
        found, told = abs(table[name]["finer"] - table[name]["meant"]), table[name]["error"]
        assert 0 < found < told, name
    assert table["energy"]["meant"] == step.energy and table["energy"]["error"] == step.energy_error
    shown = list(summary_lines(recording, tmp_path))
    (how,) = (line for line in shown if line.startswith("how sure"))
    assert how.endswith("with estimated errors")
    (energy,) = (line for line in shown if line.startswith("  energy   ") and "±" in line and "%" not in line)
    assert energy.endswith(f"± {table['energy']['error'] / table['energy']['meant']:.1e}")
    on_page = {told.title: told.error for told in told_numbers(recording.summary)}
    assert on_page["energy"].endswith(f", {100 * table['energy']['change']:+.2g} % on the finest mesh")


def test_on_the_finest_mesh_there_is_no_finer_one(tmp_path: Path) -> None:
    case = sheared_pair("penalty").model_copy(update={"accuracy": 1e-9, "mesh": MeshChoice(grading=0)})
    _, summary = last(case, tmp_path / "out", verify_mesh=True)
    assert summary["finer_mesh"] == {"failed": "no finer mesh finds an equilibrium, or there is none"}


def test_a_finer_mesh_without_an_equilibrium_costs_the_run_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failed(*_: object, **__: object) -> dict[str, Any]:
        raise StepFailed(Outcome.RELEASE_FAILED, 1.0)

    monkeypatch.setattr(recording_module, "finer_result", failed)
    recording = record(sheared_pair("penalty"), tmp_path / "out", pictures=False, verify_mesh=True)
    assert list(recording) and recording.certified
    assert recording.summary["finer_mesh"] == {"failed": Outcome.RELEASE_FAILED.value}
    shown = list(summary_lines(recording, tmp_path))
    assert any(line.startswith("mesh         not verified: ") for line in shown)
    assert any(line.endswith("errors not estimated: accuracy = inf") for line in shown)


def test_a_stiffer_penalty_is_followed_from_the_first_level_where_bonds_remember(monkeypatch) -> None:
    followed = []

    def noted(additions: Additions, scene: AnyCase | BodyScene, clock: Clock | None = None) -> Simulation:
        followed.append(scene.level_factors)
        return made(additions, scene, clock)

    levels = ["load.levels=[1.0, 0.5]", "load.displacement=[0.05, 0.0]", "tissue.rows=1", "tissue.cols=2"]
    case = read_case("shear-cohesive", [*levels, "expected=[]", "mesh.order=2", "accuracy=inf"])
    *_, last = Simulation(case).accepted_steps()
    made = Additions.simulation
    monkeypatch.setattr(Additions, "simulation", noted)
    table = stiffer_result(case, Additions(), last.report)
    assert followed == [(1.0, 0.5)]
    assert abs(table["energy"]["change"]) < 0.05
