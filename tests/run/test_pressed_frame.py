"""Tissues that are pressed: walls buckle, surfaces of lumens fold, and walls come into contact with themselves."""

from __future__ import annotations

from ngcell.build.simulation import Simulation
from ngcell.results.certificate import Certificate
from ngcell.scene import Case


def test_a_tied_tissue_that_leaves_a_saddle_is_in_contact_with_itself_below_it():
    """On the second mesh it is on a saddle. Below it, elements fold between the points of the quadrature rule; by a
    finer rule corners of lumens close until their sides pass each other, unless they are in contact."""
    certificate = first_tied({"kind": "frame", "stretch": [0.75, 0.75], "levels": 1})
    assert certificate.passed, [check for check in certificate.checks if not check.passed]
    (curvature,) = (check for check in certificate.checks if check.name == "lowest_curvature")
    assert curvature.value > 0


def test_a_tied_tissue_that_leaves_a_saddle_is_in_balance_on_the_next_mesh():
    certificate = first_tied({"kind": "plates", "stretch": 0.9, "levels": 1})
    assert certificate.passed, [check for check in certificate.checks if not check.passed]


def first_tied(load: dict[str, object]) -> Certificate:
    """Return the certificate of four cells that are pressed, tied to each other."""
    scene = {
        "accuracy": 0.1,
        "tissue": {"rows": 2, "cols": 2, "wall": 0.1},
        "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
        "load": load,
        "contact": {"kind": "penalty"},
    }
    step = next(Simulation(Case.model_validate(scene)).accepted_steps())
    assert step.record.phase == "tied"
    return step.measurement.certificate
