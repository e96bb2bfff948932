"""One word for one thing, and the field's: words that the project once had for itself do not come back.

Text is split into words first: `spring_count`, `SpringCount`, `spring-count` and "spring count" are all "spring count".
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SUFFIXES = {".py", ".toml", ".md", ".txt", ".csv", ".json", ".cff"}
FOLDERS = ("ngcell", "tests", "tools", "cases", "docs")
FILES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "pyproject.toml")

#: A word that is not used, and what says it.
INSTEAD = {
    r"tether\w*": "proximal term",
    r"anchor\w*": "centre of the proximal term",
    r"springs?|sprung": "penalty term",
    r"ladders?": "continuation stages",
    r"shift(s|ed|ing)?": "damping in the solver, translation elsewhere",
    r"partners?": "contact pair, closest-point projection",
    r"push(es)?": "contact force; press",
    r"overlays?|overlaid": "intersection polygon",
    r"bulg(e|es|ed|ing)": "sagitta",
    r"turning": "exterior angle, finite-rotation update; rotating",
    r"roundness": "finite-rotation update",
    r"compact(ly|ness)?": "tied",
    r"let(s|ting)? (\w+ )?go": "released",
    r"clump\w*": "connected component of cells",
    r"in space": "in three dimensions, 3-D",
    r"walk(s|ed|ing)?": "load stepping, continuation, follow",
    r"release paths?": "continuation",
    r"improv(e|es|ing)": "multiplier update",
    r"learn(s|ed|t|ing)?": "multiplier update",
    r"hast(e|y)|hasten\w*": "penalty increase",
    r"stations?|stationed": "quadrature point",
    r"slip (curvature|correction|in the gap)|(curvature|side) slip": "curvature correction",
    r"watch(ed|es|ing)?": "point constraint",
    r"chatter\w*": "active-set cycling",
    r"carried": "lifting; held, had, borne",
    r"travel\w*": "prescribed displacement",
    r"standing": "checkpoint",
    r"blueprints?": "discretisation",
    r"footprints?": "memory estimate",
    r"for each (length|area) at rest": "nominal, per reference length",
    r"(hang|hangs|hanging|hung) (on|upon|together)": "depend on, are connected",
    r"heal(s|ed|ing)?": "reset",
    r"drawn bod(y|ies)": "user-defined bodies",
    r"edges? of (a |the |its |each |all )?(3 d )?(faces?|solids?|prisms?|facets?)": "facet",
}

#: Where a word is another's, or means what everybody takes it for: the words around it, and the reason.
EXCEPTIONS = {
    r"(ast|os|path) walk": "functions of the standard library that visit a tree",
    r"bbox to anchor": "an argument of matplotlib",
    r"myst heading anchors": "a setting of MyST",
    r"in space (bodies|scalar|vector|free|elements?)": "Python's `in` before the parts of an object called `space`",
    r"edges of the face or": "a planar face of `netgen.occ` has edges",
    r"np roll shift|shift [01](?= axis)": "an argument of numpy",
}

#: The list itself.
HERE = Path(__file__).resolve()
CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")


def texts() -> Iterator[Path]:
    for folder in FOLDERS:
        yield from (path for path in sorted((ROOT / folder).rglob("*")) if path.suffix in SUFFIXES and path != HERE)
    yield from (ROOT / name for name in FILES)


def words(line: str) -> str:
    """Return the words of a line, in small letters, with a blank between them."""
    return " ".join(re.findall(r"[a-z]+|\d+", CAMEL.sub(" ", line).lower()))


def found(text: str) -> list[str]:
    """Return the words of a text that are not used, each with its line's number."""
    other, any_of_ours = whole(*EXCEPTIONS), whole(*INSTEAD)
    ours = {whole(pattern): instead for pattern, instead in INSTEAD.items()}
    lines = [other.sub("", words(line)) for line in text.splitlines()]
    return [
        f"{number}: '{match.group()}' ({instead})"
        for number, line in enumerate(lines, 1)
        if any_of_ours.search(line)
        for pattern, instead in ours.items()
        for match in pattern.finditer(line)
    ]


def whole(*patterns: str) -> re.Pattern[str]:
    """Return the pattern of any of these, as whole words."""
    return re.compile("|".join(rf"\b(?:{pattern})\b" for pattern in patterns))


@pytest.mark.parametrize("path", list(texts()), ids=lambda path: str(path.relative_to(ROOT)))
def test_a_text_uses_the_words_of_the_field(path: Path) -> None:
    assert found(path.read_text()) + found(str(path.relative_to(ROOT))) == []


@pytest.mark.parametrize("text", ["SpringModel", "_watched_count", "COMPACT_FAILED", "let it go", "hang on", "K-walks"])
def test_words_are_found_inside_names(text: str) -> None:
    assert len(found(text)) == 1


@pytest.mark.parametrize("text", ["ast.walk(tree)", "outstanding", "springy", "edges of the polygon"])
def test_other_words_are_not(text: str) -> None:
    assert found(text) == []
