"""Few lines stand twice.

A line is repeated if it lies in a run of consecutive lines that stands elsewhere too, in the same file or another, and
the run is at least `RUN` lines long (three in cases, whose sections are short). Lines are compared without indentation,
comments and doubled blanks; blank lines, lines of brackets only, headings of docstring sections, and imports do not
count. All copies but the first count as repeated, so that the share is what could be removed.
"""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Iterable
from itertools import chain
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUN = {".py": 6, ".toml": 3}
TRIVIAL = re.compile(r"[\s()\[\]{},:]*|-+|Parameters|Attributes|Returns|Yields|Raises|Notes|References|Examples|\"{3}")

#: What is measured together, and the largest share of its lines that may be repeated.
LIMITS = {"ngcell": (["ngcell"], 0.005), "tests and tools": (["tests", "tools"], 0.01), "cases": (["cases"], 0.03)}

Line = tuple[Path, int, str]


def lines(path: Path) -> list[Line]:
    """Return the lines that count, with their numbers."""
    text = path.read_text()
    bare = text.splitlines() if path.suffix == ".toml" else without_comments_and_imports(text)
    words = ((number, " ".join(line.split())) for number, line in enumerate(bare, 1))
    return [(path, number, line) for number, line in words if line[:1] != "#" and not TRIVIAL.fullmatch(line)]


def without_comments_and_imports(text: str) -> list[str]:
    """Blank comments and import statements out, and leave all other lines where they are."""
    found = text.splitlines()
    opening: tokenize.TokenInfo | None = None
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            found[token.start[0] - 1] = found[token.start[0] - 1][: token.start[1]]
        elif token.type == tokenize.NAME and opening is None:
            opening = token
        elif token.type == tokenize.NEWLINE:
            if opening is not None and opening.string in {"import", "from"}:
                for number in range(opening.start[0], token.start[0] + 1):
                    found[number - 1] = ""
            opening = None
    return found


def repeated(files: Iterable[list[Line]], run: int) -> list[Line]:
    """Return the lines of all runs that have stood before."""
    seen: set[tuple[str, ...]] = set()
    found: list[Line] = []
    for file in files:
        again: set[int] = set()
        for start in range(len(file) - run + 1):
            window = tuple(line for *_, line in file[start : start + run])
            again |= set(range(start, start + run)) if window in seen else set()
            seen.add(window)
        found += (file[index] for index in sorted(again))
    return found


@pytest.mark.parametrize("part", LIMITS)
def test_few_lines_stand_twice(part: str) -> None:
    folders, limit = LIMITS[part]
    suffix = ".toml" if part == "cases" else ".py"
    paths = sorted(chain.from_iterable((ROOT / folder).rglob(f"*{suffix}") for folder in folders))
    files = [lines(path) for path in paths]
    found = repeated(files, RUN[suffix])
    total = sum(map(len, files))
    shown = "\n".join(f"{path.relative_to(ROOT)}:{number}: {line}" for path, number, line in found[:40])
    assert len(found) <= limit * total, f"{len(found)} of {total} lines, {len(found) / total:.1%}:\n{shown}"


def test_copies_are_found_and_imports_and_comments_are_not() -> None:
    block = ["a = 1", "b = 2", "", "c = 3  # why", "d = 4", "(", "e = 5", ")", "f = 6"]
    imports = ["from x import (", "    y,", ")", "import z"]
    texts = ["\n".join([*imports, *block]) + "\n", "\n".join([*imports, "    # aside", *block, "g = 7"]) + "\n"]
    here = Path("x.py")
    files = [
        [(here, 0, line) for line in without_comments_and_imports(text) if not TRIVIAL.fullmatch(line)]
        for text in texts
    ]
    assert [line.strip() for *_, line in repeated(files, 6)] == ["a = 1", "b = 2", "c = 3", "d = 4", "e = 5", "f = 6"]
    assert repeated(files[:1], 6) == [] and repeated(files, 7) == []
