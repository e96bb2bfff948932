"""Where an order has changed a state: in elements that a grade splits, or in others."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.results.elsewhere import share_elsewhere

PAIR = ("tissue.rows=1", "tissue.cols=2", "accuracy=inf", "mesh.order=2")


def mesh(grading: int) -> Simulation:
    return Simulation(ngcell.read_case("shear-empty-3x3", [*PAIR, f"mesh.grading={grading}"]))


def test_a_change_is_counted_in_the_elements_that_are_not_split_towards_corners():
    """All are stretched alike, so that each counts by its area and its modulus."""
    coarse, fine = mesh(1), mesh(2)
    space, moduli = coarse.space, coarse.shear_moduli
    size = areas(coarse)
    is_long = size > 0.5 * size.max()
    assert moduli.shape == size.shape and np.ptp(moduli) == 0
    still, stretched = np.zeros(space.unknowns), np.zeros((2, space.size))
    stretched[0] = 1e-3 * space.rest[0]
    whole = share_elsewhere(space, moduli, still, stretched.ravel(), fine.space)
    assert whole == pytest.approx(size[is_long].sum() / size.sum(), rel=1e-9)
    soft_corners = share_elsewhere(space, np.where(is_long, 1.0, 0.0), still, stretched.ravel(), fine.space)
    assert soft_corners == pytest.approx(1.0, abs=1e-12)
    assert share_elsewhere(space, moduli, still, still, fine.space) == 0.0


def areas(simulation: Simulation) -> np.ndarray:
    return np.array(ngsolve.Integrate(ngsolve.CF(1), simulation.space.mesh, element_wise=True))
