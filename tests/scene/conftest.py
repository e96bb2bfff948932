"""A small case file that each test may bend."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

GOOD = """\
title = "two cells"

[tissue]
rows = 1
cols = 2
side = 1.0
wall = 0.1

[material]
kind = "mooney-rivlin"
c1 = 1.0
c2 = 0.5
bulk_modulus = 100.0

[load]
kind = "plates"
displacement = [0.1, 0.0]
levels = 2
"""


@pytest.fixture
def write_case(tmp_path: Path) -> Callable[..., Path]:
    """Write the good case with pieces of its text replaced, each as (old, new)."""

    def write(*replacements: tuple[str, str]) -> Path:
        text = GOOD
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new)
        file = tmp_path / "bent.toml"
        file.write_text(text)
        return file

    return write
