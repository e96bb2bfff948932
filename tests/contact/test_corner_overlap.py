"""How deep a corner lies in a wall is told without the factor by which gaps fade beside corners."""

from __future__ import annotations

import numpy as np
import pytest
from netgen import occ

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.problem.problem import Problem
from tests.contact.stacks import LAW, REACH, stack

DEPTH = 0.004


def test_the_depth_of_a_corner_is_that_of_its_tip():
    lower = occ.MoveTo(-0.5, 0.0).Rectangle(1.0, 0.5).Face()
    upper = occ.MoveTo(0.0, 0.5).LineTo(0.4, 0.9).LineTo(-0.4, 0.9).Close().Face()
    pile = stack((lower, upper), (0.3, 0.3), 2)
    stiffness = penalty_stiffness(pile.walls, np.full(2, LAW.plane_strain_modulus), 10.0)
    term = ContactTerm(PenaltyContact(pile.walls, stiffness, REACH, single_pass_corners=True))
    free = np.zeros((2, pile.space.size), dtype=bool)
    at = Problem(pile.space, [BodyEnergy(pile.space, [LAW] * 2), term], free).at(pile.upper_moved((0.03, -DEPTH))).at
    thickness = np.array([0.5, 0.2])
    assert term.overlap(at) == pytest.approx(DEPTH)
    assert term.overlap_over(at, thickness) == pytest.approx(DEPTH / 0.2)
    faded = -term.found(at).gaps(at.positions).min()
    assert faded == pytest.approx(2**0.5 * DEPTH, rel=1e-2)
