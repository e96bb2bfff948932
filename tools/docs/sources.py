"""Pages of the repository as sources of the site: copied, with links that follow, and tables of contents."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from os.path import relpath
from pathlib import Path

from tools.places import DOCS, ROOT

#: Documents beside `docs` that are pages of the site, too.
TOP = ("CONTRIBUTING.md", "CHANGELOG.md")
#: Where they and the tables of results are in the site; all else keeps its path.
TABLES, REPOSITORY = "tables", "repository"
_LINK = re.compile(r"(?<=\]\()([^)\s#]+)(?=[)#])")
_SITE_ONLY = re.compile(r"<!-- site: (.*?) -->", re.DOTALL)
_FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def copy_pages(source: Path) -> None:
    """Write the pages of `docs`, and what they link in the repository, into the folder that Sphinx reads."""
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("__pycache__", "*.ipynb"))
    waiting = [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in TOP)]
    done = set()
    while waiting:
        page = waiting.pop(0)
        if page in done:
            continue
        done.add(page)
        waiting += [path for path in linked(page) if path.suffix == ".md"]
        target = source / place(page)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(as_source(page))
        _copy_files(page, source)
    index = source / "index.md"
    others = sorted(str(place(page)) for page in done if place(page).parts[0] == TABLES)
    index.write_text(f"{index.read_text()}\n{_toctree('Tables of results', others)}")


def place(path: Path) -> Path:
    """Return where a file of the repository is in the site."""
    if path.is_relative_to(DOCS):
        return path.relative_to(DOCS)
    if path.is_relative_to(ROOT / "tools" / "results"):
        return Path(TABLES) / path.name
    if path.parent == ROOT and path.suffix == ".md":
        return Path(path.name.lower())
    return Path(REPOSITORY) / path.relative_to(ROOT)


def linked(page: Path) -> Iterator[Path]:
    """Yield the files of the repository that a page links."""
    for target in _LINK.findall(_FENCE.sub("", page.read_text())):
        path = (page.parent / target).resolve()
        if not re.match(r"[a-z]+:", target) and path.is_file():
            yield path


def as_source(page: Path) -> str:
    """Return the text of a page as Sphinx reads it.

    Every page has a title, links lead to where their targets are in the site, and what is written for the site alone is
    shown. The first page gets a table of contents for each of its lists of links.
    """
    text = _SITE_ONLY.sub(r"\1", page.read_text())
    if not text.startswith("# "):
        text = f"# {page.stem.capitalize()}\n\n{text}"
    if page == DOCS / "index.md":
        text += _tables_of_contents(text)
    return _LINK.sub(lambda link: _moved(page, link.group()), text)


def _moved(page: Path, target: str) -> str:
    path = (page.parent / target).resolve()
    if re.match(r"[a-z]+:", target) or not path.is_file():
        return target
    return relpath(place(path), place(page).parent)


def _copy_files(page: Path, source: Path) -> None:
    for path in linked(page):
        target = source / place(path)
        if path.suffix != ".md" and not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


def _tables_of_contents(text: str) -> str:
    """Return a hidden table of contents for each section of the first page that is a list of links."""
    found = ""
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        pages = [str(_site_path(target)) for target in re.findall(r"^- \[[^\]]+\]\(([^)\s#]+)\)", body, re.MULTILINE)]
        found += _toctree(title, pages)
    return found


def _site_path(target: str) -> Path:
    path = (DOCS / target).resolve()
    return place(path) if path.is_file() else Path(target)


def _toctree(caption: str, pages: list[str]) -> str:
    lines = "\n".join(str(Path(page).with_suffix("")) for page in pages)
    return f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{lines}\n```\n" if pages else ""
