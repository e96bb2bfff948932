"""NGSolve's contact boundaries are as stiff as the method says, whenever that changes."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.by_ngsolve import NgsolveTerm
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from tests.tissues import LAW, small_tissue


def test_contact_that_is_made_stiffer_stores_more_with_the_same_pairs():
    tissue = small_tissue(1, 2, order=2)
    moduli = np.full(tissue.space.body_count, LAW.plane_strain_modulus)
    term = NgsolveTerm(tissue.walls, penalty_stiffness(tissue.walls, moduli, 10.0), 0.1)
    at = tissue.space.configuration(tissue.body_translation(1, np.array([-0.03, 0.01])))

    def energies() -> tuple[float, float]:
        anew = tissue.space.configuration(at.displacement)
        return term.value(anew), ContactTerm.value(term, anew)

    soft, own = energies()
    assert soft == pytest.approx(own, rel=1e-6) and soft > 0
    term.method.stiffen()
    assert energies() == (pytest.approx(10 * soft, rel=1e-9), pytest.approx(10 * own, rel=1e-9))
    term.start_from(NgsolveTerm(tissue.walls, term.method.stiffness, 0.1), at)
    assert energies() == (pytest.approx(soft, rel=1e-9), pytest.approx(own, rel=1e-9))
