"""What the terminal says of walls that would rupture."""

from __future__ import annotations

from typing import Any

import pytest

from ngcell.cli.summary import rupture_lines

LOAD: dict[str, Any] = {
    "load_factor": 0.5, "error": 0.01, "interpolation_error": 0.001, "between": (0.4, 0.6), "cell": 3,
    "place": (1.0, 2.0),
}  # fmt: skip
TABLE: dict[str, Any] = {
    "load": LOAD, "largest_utilisation": 1.2, "largest_utilisation_error": 0.02, "first_separation": 0.7,
    "cells": {"whole": [0], "separated": [1, 2], "burst": [3]}, "work_of_separation": 0.25, "work_of_rupture": 0.125,
}  # fmt: skip


def test_nothing_is_said_where_nothing_is_known():
    assert list(rupture_lines({})) == []


@pytest.mark.parametrize(
    "changes, line",
    [
        ({}, "rupture      of cell 3 at load factor 0.5 ± 2 %"),
        ({"load": None}, "rupture      of no wall; largest utilisation 1.2 ± 2 %"),
        ({"load": None, "largest_utilisation_error": float("nan")}, "rupture      of no wall; largest utilisation 1.2"),
        (
            {"load": LOAD | {"error": float("nan")}},
            "rupture      of cell 3 at load factor 0.5, error of the mesh not estimated",
        ),
        ({"load": LOAD | {"between": (0.5, 0.5)}}, "rupture      of cell 3 at load factor 0.5 or before"),
        ({}, "separation   from load factor 0.7 on"),
        ({"first_separation": None}, "separation   of no walls"),
        ({}, "cells        1 whole, 2 separated, 1 burst"),
        ({}, "work         0.25 of separation, 0.125 of rupture"),
    ],
)
def test_a_line_each(changes, line):
    assert line in list(rupture_lines(TABLE | changes))
