"""Energies and gradients at the last displacement are told again, where nothing else changes them."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.mechanics.last_found import LastFound
from ngcell.mechanics.symbolic import OwnEnergy
from ngcell.mechanics.symbolic_sum import SymbolicSum
from tests.tissues import small_tissue


def test_it_is_found_once_at_a_place_and_anew_where_the_place_has_moved():
    known, place, asked = LastFound[float](True), np.zeros(3), []

    def find() -> float:
        asked.append(place.copy())
        return float(place.sum())

    assert [known.of(place, find), known.of(place.copy(), find)] == [0, 0] and len(asked) == 1
    place += 1.0  # the same array, at another place
    assert known.of(place, find) == 3 and len(asked) == 2


def test_stored_energy_is_remembered_and_its_gradient_is_the_callers_own():
    tissue = small_tissue(1, 2)
    at = tissue.space.configuration(tissue.smooth(0.02, 4))
    assert tissue.bulk.remembers
    first = tissue.bulk.gradient(at)
    kept = first.copy()
    first[:] = np.nan
    np.testing.assert_array_equal(tissue.bulk.gradient(at), kept)
    assert tissue.bulk.value(at) == tissue.bulk.value(at)


def test_an_energy_with_a_parameter_follows_it():
    tissue, stiffness = small_tissue(1, 2), ngsolve.Parameter(1.0)
    own = OwnEnergy(tissue.space, lambda u, mesh: stiffness * u[0] ** 2 * ngsolve.dx)
    for term in (own, SymbolicSum([tissue.bulk, own])):
        stiffness.Set(1.0)
        at = tissue.space.configuration(tissue.smooth(0.02, 4))
        energy, force = term.value(at), term.gradient(at)
        stiffness.Set(2.0)
        more = own.value(at) / 2
        assert more > 0 and term.value(at) == pytest.approx(energy + more)
        assert np.abs(term.gradient(at) - force).max() > 0
