"""A release installs and solves outside of the repository, and says everywhere which one it is."""

from __future__ import annotations

import re
import tarfile
from pathlib import Path

import pytest

import ngcell
from tools.docs import release
from tools.places import ROOT

TEMPLATES = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return release.built(tmp_path_factory.mktemp("dist"))


def test_what_is_built_installs_and_solves_elsewhere(distributions: tuple[Path, Path], tmp_path: Path) -> None:
    _, wheel = distributions
    place, version, checked, solved = release.tried(release.installed(wheel, tmp_path / "environment"), tmp_path)
    assert Path(place.strip()).is_relative_to(tmp_path)
    assert ngcell.__version__ in version
    assert re.search(r"^bodies +9$", checked, flags=re.MULTILINE)
    assert "certified" in solved and (tmp_path / "out" / "tissue.png").exists()


def test_a_source_distribution_holds_what_its_tests_and_its_site_take(distributions: tuple[Path, Path]) -> None:
    source, _ = distributions
    with tarfile.open(source) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    needed = {"docs/index.md", "docs/conf.py", "docs/static/site.css", "docs/gallery/1_shear.py", "tools/docs/site.py"}
    assert names >= needed | {"CITATION.cff", "cases/shear-empty.toml", ".github/ISSUE_TEMPLATE/wrong-result.yml"}


def test_the_version_is_the_same_everywhere() -> None:
    changes, citation = ((ROOT / name).read_text() for name in ("CHANGELOG.md", "CITATION.cff"))
    released = re.findall(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)$", changes, re.MULTILINE)
    cited = dict(re.findall(r"^(version|date-released): (\S+)$", citation, re.MULTILINE))
    assert released[0] == (ngcell.__version__, cited["date-released"]) == (cited["version"], cited["date-released"])


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda path: path.stem)
def test_an_issue_template_has_what_github_asks_for(template: Path) -> None:
    text = template.read_text()
    assert all(re.search(rf"^{key}: ", text, flags=re.MULTILINE) for key in ("name", "description"))
    identifiers = re.findall(r"^    id: (\w+)$", text, flags=re.MULTILINE)
    assert identifiers and len(identifiers) == len(set(identifiers)) == text.count("  - type: textarea")


def test_whoever_reports_a_result_is_asked_for_what_it_takes_to_run_it_again() -> None:
    text = (ROOT / ".github" / "ISSUE_TEMPLATE" / "wrong-result.yml").read_text()
    assert all(name in text for name in ("case.toml", "summary.json", "history.csv", "Versions", "ngsolve"))
