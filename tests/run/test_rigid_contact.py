"""Where overlaps alone make an error too large, contact is made stiffer and the mesh no finer."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ngcell.build.refinement import Refinement
from ngcell.contact.methods.penalty import STIFFEN
from ngcell.results.error import Numbers, estimate
from ngcell.results.parts_of_error import Refining

ACCURACY, GAP = 0.01, 0.5


def numbers(change: float, overlap: float) -> Numbers:
    """On one mesh; the next changes the mean gap by `change` times itself."""
    return Numbers(1.0, 1.0, np.array([1.0, 0.0]), 1.0, (1 + change) * GAP, GAP, (1e-9, 1e-9, 1e-2), overlap=overlap)


def step() -> Any:
    return SimpleNamespace(level=0, accepted=SimpleNamespace(minimum=object()))


class Mesh:
    """A mesh whose contact can be made stiffer, once, or not at all."""

    def __init__(self, can_be_stiffer: bool) -> None:
        self.can_be_stiffer, self.asked = can_be_stiffer, 0

    def stiffer(self, found: Any) -> Any:
        self.asked += 1
        return step() if self.can_be_stiffer else SimpleNamespace(level=0, accepted=found.accepted)

    def numbers(self, found: Any) -> Numbers:
        return replace(numbers(0.0, 0.003 * GAP / STIFFEN))


@pytest.mark.parametrize(
    ("of_mesh", "can_be_stiffer", "asked"),
    [
        (0.0055, True, 0),  # small enough as it is
        (0.0085, True, 1),
        (0.0085, False, 1),
        (0.011, True, 0),  # the mesh alone errs by too much
    ],
)
def test_contact_is_stiffer_where_it_decides_about_the_accuracy(of_mesh, can_be_stiffer, asked):
    refined = [Refining(0.5)]
    found, mesh, last = [numbers(of_mesh, 0.0), numbers(0.0, 0.003 * GAP)], Mesh(can_be_stiffer), step()
    refinement: Any = SimpleNamespace(_accuracy=ACCURACY, _levels=[mesh])
    errors = estimate(found, refined)
    assert errors.mean_gap / GAP == pytest.approx(of_mesh + 0.003)
    after, told = Refinement._by_rigid_contact(refinement, last, found, refined, errors)
    assert mesh.asked == asked
    if asked and can_be_stiffer:
        assert after is not last and told.mean_gap / GAP == pytest.approx(of_mesh + 0.003 / STIFFEN)
        assert told.relative <= ACCURACY < errors.relative
    else:
        assert told is errors and after.accepted is last.accepted
