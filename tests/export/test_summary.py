import errno
import os

import numpy as np
import pytest

from ngcell.errors import OutputError
from ngcell.export import read_summary, write_summary


def test_numbers_come_back_and_infinite_ones_are_null(tmp_path):
    write_summary(
        tmp_path,
        {
            "energy": np.float64(1 / 3),
            "steps": np.int64(4),
            "certified": np.bool_(True),
            "gap": float("nan"),
            "ratio": np.float32("inf"),
            "levels": (0.5, np.array([1.0, -np.inf])),
            "seconds": {"meshing": 0.1},
        },
    )
    assert read_summary(tmp_path) == {
        "energy": 1 / 3,
        "steps": 4,
        "certified": True,
        "gap": None,
        "ratio": None,
        "levels": [0.5, [1.0, None]],
        "seconds": {"meshing": 0.1},
    }


def test_a_failed_write_keeps_the_summary_before_it(tmp_path, monkeypatch):
    write_summary(tmp_path, {"steps": 1})

    def refuse(*paths):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OutputError, match=r"summary\.json: No space left"):
        write_summary(tmp_path, {"steps": 2})
    assert read_summary(tmp_path) == {"steps": 1}
    assert [path.name for path in tmp_path.iterdir()] == ["summary.json"]


@pytest.mark.parametrize("text, said", [(None, "is .* the result of a run"), ("{", "is not JSON"), ("[]", "a list")])
def test_a_summary_that_cannot_be_read_is_named(tmp_path, text, said):
    if text is not None:
        (tmp_path / "summary.json").write_text(text)
    with pytest.raises(OutputError, match=said):
        read_summary(tmp_path)
