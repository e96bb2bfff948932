"""What a script may add to the package: each example is short, runs, and states a number with a reason."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "docs" / "examples").glob("*.py"))
LONGEST = 25


def test_every_open_door_has_an_example() -> None:
    doors = {"law", "cohesive_law", "contact", "tissue", "load", "body_load", "observable", "strategy", "energy"}
    assert {example.stem.removeprefix("own_") for example in EXAMPLES} >= doors


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_states_a_number(example: Path) -> None:
    text = example.read_text()
    written = [line for line in text.splitlines() if line.strip()]
    assert len(written) <= LONGEST
    assert "assert" in text
    runpy.run_path(str(example))
