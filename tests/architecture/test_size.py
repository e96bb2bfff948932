"""A module can be read in one sitting."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ngcell

PACKAGE = Path(ngcell.__file__).parent
LENGTH = {str(path.relative_to(PACKAGE)): len(path.read_text().splitlines()) for path in sorted(PACKAGE.rglob("*.py"))}


@pytest.mark.parametrize("module", LENGTH)
def test_no_module_has_more_than_300_lines(module: str) -> None:
    assert LENGTH[module] <= 300


def test_nine_modules_of_ten_have_at_most_220_lines() -> None:
    longest = sorted(LENGTH, key=LENGTH.__getitem__, reverse=True)[: len(LENGTH) // 10 + 1]
    assert np.percentile(list(LENGTH.values()), 90) <= 220, {module: LENGTH[module] for module in longest}
