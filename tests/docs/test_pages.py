"""Every block of code of the tutorial and of the how-to pages runs, and the tutorial prints what it says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import ngcell
from tests.docs.pages import FENCE, Page
from tools.places import DOCS

HOW_TO = sorted((DOCS / "how-to").glob("*.md"))
#: Pages whose cases and scripts other tests take: tests/run/test_documents.py, test_end_to_end.py and
#: test_expected_numbers.py. Commands of all documents are checked in test_commands.py.
ELSEWHERE = {
    "cases": ["toml"],
    "python": ["python"],
    "output": ["python"],
    "bodies": ["toml"],
    "command-line": ["toml"],
    "rupture": ["toml"],
    "sweeps": ["toml", "python", "python"],
}


def smaller(text: str) -> str:
    """Ask for no estimate of the error, which takes most of the time, and for one level."""
    return re.sub(r"levels( ?= ?)2", r"levels\g<1>1", re.sub(r"accuracy( ?= ?)0\.1", r"accuracy\g<1>inf", text))


def labelled(text: str) -> dict[str, float]:
    """Return the numbers that are told with their errors, each by the words before it."""
    return {label: float(value) for label, value in re.findall(r"^ *(\S.*?) +(\S+) ± ", text, flags=re.MULTILINE)}


@pytest.mark.parametrize("path", HOW_TO, ids=lambda path: path.stem)
def test_a_how_to_page_runs(path: Path, tmp_path: Path) -> None:
    assert list(Page(path, tmp_path, smaller).follow())


def test_the_tutorial_prints_what_it_says(tmp_path: Path) -> None:
    told = [(printed, said) for printed, said in Page(DOCS / "tutorial.md", tmp_path).follow() if said]
    assert len(told) == 2
    for printed, said in told:
        found, promised = labelled(printed), labelled(said)
        assert promised and found.keys() >= promised.keys()
        assert [found[label] for label in promised] == [pytest.approx(value, rel=0.01) for value in promised.values()]
    for folder in ("first", "five", "own-law"):
        assert (tmp_path / "out" / folder / "tissue.png").stat().st_size > 1000
    assert "certified: True" in told[-1][0]


def test_no_page_has_a_case_or_a_script_that_no_test_takes() -> None:
    pages = sorted(set(DOCS.rglob("*.md")) - {*HOW_TO, DOCS / "tutorial.md"})
    blocks = {page.stem: [block[1] for block in FENCE.finditer(page.read_text())] for page in pages}
    tested = {page: [name for name in found if name in {"toml", "python"}] for page, found in blocks.items()}
    assert {page: languages for page, languages in tested.items() if languages} == ELSEWHERE


def test_the_first_page_starts_as_the_tutorial_does() -> None:
    (first,) = FENCE.finditer((DOCS / "index.md").read_text())
    tutorial = [line for block in FENCE.finditer((DOCS / "tutorial.md").read_text()) for line in block[2].splitlines()]
    assert set(first[2].splitlines()) <= set(tutorial)


@pytest.mark.parametrize(
    ("width", "told"),
    [(0.9, "overlap by"), (1.02, "have a gap of"), (1.0, "closes its lumen, or one side of it")],
    ids=["overlap", "gap", "wall"],
)
def test_a_tissue_is_refused_in_the_words_of_the_page(width: float, told: str, tmp_path: Path) -> None:
    lefts = (0.0, width)
    rings = (f"{x} 0, {x + 1} 0, {x + 1} 1, {x} 1, {x} 0" for x in lefts)
    (tmp_path / "cells.wkt").write_text("\n".join(f"POLYGON (({ring}))" for ring in rings))
    with pytest.raises(ngcell.CaseError, match=told):
        ngcell.Polygons(file=str(tmp_path / "cells.wkt"), wall=0.6 if width == 1 else 0.1)
    assert all(part in (DOCS / "how-to" / "own-polygons.md").read_text() for part in told.split(" its lumen, or "))
