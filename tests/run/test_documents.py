"""What the README and its pages show is true: their cases are read, and their scripts run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import ngcell

ROOT = Path(__file__).resolve().parents[2]
README, CASES, PYTHON = ROOT / "README.md", ROOT / "docs" / "cases.md", ROOT / "docs" / "python.md"


def block(document: Path, language: str) -> str:
    """Return the one block of a language that a document has."""
    (text,) = re.findall(rf"^```{language}\n(.*?)^```", document.read_text(), flags=re.DOTALL | re.MULTILINE)
    return str(text)


def test_the_case_of_the_readme_is_a_shipped_one_and_so_are_its_numbers(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(block(README, "toml"))
    case, shipped = ngcell.read_case(file), ngcell.read_case("shear-empty-3x3")
    same = {"title", "source", "expected"}
    assert case.model_dump(exclude=same) == shipped.model_dump(exclude=same)
    expected = {entry.quantity: entry.value for entry in shipped.expected}
    told = dict(re.findall(r"^(energy|mean gap) +(\S+) ± ", README.read_text(), flags=re.MULTILINE))
    assert float(told["energy"]) == pytest.approx(expected["energy"], rel=1e-3)
    assert float(told["mean gap"]) == pytest.approx(expected["mean_gap"], rel=1e-3)


def test_the_script_of_the_readme_prints_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    exec(block(README, "python"), {})
    printed = re.findall(r"(\S+): energy (\S+) ± \S+, certified: (\w+)", capsys.readouterr().out)
    said = re.findall(r"`(\S+): energy (\S+) ± \S+, certified: (\w+)`", README.read_text())
    assert [(wall, certified) for wall, _, certified in printed] == [("0.1", "True"), ("0.15", "True")]
    for (_, energy, certified), (_, told, promised) in zip(printed, said, strict=True):
        assert float(energy) == pytest.approx(float(told), rel=0.01)
        assert certified == promised


def test_the_case_with_all_entries_is_read(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(block(CASES, "toml"))
    case = ngcell.read_case(file)
    assert case.cohesion is not None and case.lumen is not None


def test_the_script_on_bodies_of_any_shape_presses_them_together(capsys: pytest.CaptureFixture[str]) -> None:
    """On a coarse mesh, which is not certified; as the page has it, the script takes minutes."""
    script = block(PYTHON, "python")
    assert "size=0.3" in script
    exec(script.replace("size=0.3", "size=0.5, order=1"), {})
    _, force = capsys.readouterr().out.split()
    assert float(force) < 0
