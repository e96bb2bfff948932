"""Shipped cases with expected numbers meet them, from the command to the summary, and a case that does not says so.

The Hertz cases take longer: `python -m tools.references expected` runs them all.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from ngcell.cli import ngcell
from ngcell.scene import read_case

PAGE = Path(__file__).parents[2] / "docs" / "bodies.md"
FAST = ["closing-rings", "parting-rings", "press-fit", "press-fit-tight", "stacked-blocks"]
#: The numbers are those of the mesh of the case.
PLAIN = ["--set", "accuracy=inf"]
FILES = {"case.toml", "history.csv", "walls.csv", "tissue.pvd", "summary.json", "tissue.png", "gap.png"}


@pytest.mark.parametrize("name", FAST)
def test_case_meets_its_expected_numbers(name: str, tmp_path: Path) -> None:
    answer = CliRunner().invoke(ngcell, ["solve", name, "--out", str(tmp_path / name), "--quiet", *PLAIN])
    assert answer.exit_code == 0, answer.output
    assert "\nexpected     met: " in answer.stdout
    assert FILES <= {file.name for file in (tmp_path / name).iterdir()}
    summary = json.loads((tmp_path / name / "summary.json").read_text())
    wanted = read_case(name).expected
    assert len(summary["expected"]) == len(wanted)
    for finding in summary["expected"]:
        assert finding["passed"]
        share = abs(finding["expected"]) or 1.0
        assert finding["measured"] == pytest.approx(finding["expected"], abs=finding["tolerance"] * share)
        assert (finding["quantity"], finding["place"]) in {(entry.quantity, entry.place) for entry in wanted}


def test_case_that_misses_a_number_is_not_certified(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    answer = CliRunner().invoke(
        ngcell, ["solve", "stacked-blocks", "--out", str(folder), "--quiet", *PLAIN, "--set", "expected.0.value=0.5"]
    )
    assert answer.exit_code == 4
    assert "expected     1 of 3 NOT MET" in answer.stdout
    assert answer.stdout.startswith("certified    NO: converged, but a number")
    assert "a number is not as the case expects" in answer.stdout
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["certified"] is False
    assert [finding["passed"] for finding in summary["expected"]] == [False, True, True]
    with open(folder / "history.csv") as file:
        assert {row["certified"] for row in csv.DictReader(file)} == {"True"}


def test_the_page_on_own_bodies_draws_a_case_that_runs(tmp_path: Path) -> None:
    file = tmp_path / "ring.toml"
    file.write_text(PAGE.read_text().partition("```toml")[2].partition("```")[0])
    answer = CliRunner().invoke(ngcell, ["solve", str(file), "--out", str(tmp_path / "out"), "--quiet"])
    assert answer.exit_code == 0, answer.output


def test_check_builds_a_case_of_bodies() -> None:
    answer = CliRunner().invoke(ngcell, ["check", "press-fit"])
    assert answer.exit_code == 0
    assert "bodies                   2" in answer.stdout.splitlines()


def test_numbers_of_a_tissue_are_columns_of_its_history(tmp_path: Path) -> None:
    expected = (
        'expected=[{ level = 1.0, quantity = "parted_pairs", value = 0.0, tolerance = 0.5, origin = "a single cell" },'
        ' { level = 1.0, quantity = "energy", value = 1.0, tolerance = 1e-3, origin = "a wrong guess" }]'
    )
    small = [
        "tissue.rows=1",
        "tissue.cols=1",
        "load.displacement=[0.1, 0.0]",
        "load.levels=1",
        "accuracy=inf",
        expected,
    ]
    overrides = [word for entry in small for word in ("--set", entry)]
    answer = CliRunner().invoke(ngcell, ["solve", "shear-empty-3x3", "--out", str(tmp_path / "t"), "-q", *overrides])
    assert answer.exit_code == 4
    found = json.loads((tmp_path / "t" / "summary.json").read_text())["expected"]
    assert {finding["quantity"]: finding["passed"] for finding in found} == {"parted_pairs": True, "energy": False}
