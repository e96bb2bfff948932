"""The README is short, every page is found from it, and no link of a document points to what is not there."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README, PAGES = ROOT / "README.md", sorted((ROOT / "docs").rglob("*.md"))
DOCUMENTS = [README, *PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
LONGEST = 120


def prose(text: str) -> str:
    """Return a document without its blocks of code, and without what only the site shows."""
    return re.sub(r"^```.*?^```|<!--.*?-->", "", text, flags=re.DOTALL | re.MULTILINE)


def links(text: str) -> Iterator[tuple[str, str]]:
    """Yield path and heading of each relative link; a link inside the document has an empty path."""
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(text)):
        if not re.match(r"[a-z]+:", target):
            path, _, heading = target.partition("#")
            yield path, heading


def headings(text: str) -> set[str]:
    """Return the names by which headings are linked, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", prose(text), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def broken(document: Path, text: str) -> list[str]:
    """Return the relative links of a document that lead nowhere."""
    wrong = []
    for path, heading in links(text):
        target = (document.parent / path).resolve() if path else document
        if not target.exists() or heading and heading not in headings(target.read_text() if path else text):
            wrong.append(f"{path}#{heading}")
    return wrong


def linked(document: Path) -> set[Path]:
    return {(document.parent / path).resolve() for path, _ in links(document.read_text()) if path}


def test_the_readme_can_be_read_in_two_minutes() -> None:
    assert len(README.read_text().splitlines()) <= LONGEST


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(document: Path) -> None:
    assert broken(document, document.read_text()) == []


@pytest.mark.parametrize("link", ["docs/no-page.md", "docs/theory.md#no-heading", "#no-heading", "docs/no-picture.png"])
def test_a_broken_link_is_found(link: str) -> None:
    assert len(broken(README, f"# A\n\n[words]({link}) and [others](#a)")) == 1


def test_every_page_is_found_from_the_readme() -> None:
    found, waiting = {README}, [README]
    while waiting:
        new = {path for path in linked(waiting.pop()) if path.suffix == ".md"} - found
        found |= new
        waiting += new
    assert found >= {ROOT / "CONTRIBUTING.md", *PAGES}


def test_the_first_page_lists_every_other() -> None:
    assert linked(ROOT / "docs" / "index.md") >= set(PAGES) - {ROOT / "docs" / "index.md"}


def test_every_picture_and_example_is_in_a_page() -> None:
    shown = set().union(*(linked(document) for document in DOCUMENTS))
    assert {*(ROOT / "docs").glob("*.png"), *(ROOT / "docs" / "examples").glob("*.py")} <= shown


def test_a_source_distribution_holds_what_the_documents_link() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    included = settings["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]
    files = {path for entry in included for path in ROOT.glob(entry.lstrip("/"))}
    needed = set(DOCUMENTS).union(*(linked(document) for document in DOCUMENTS))
    assert [path for path in needed if not files & {path, *path.parents}] == []
