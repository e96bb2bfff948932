"""What a case may say about cohesion."""

from __future__ import annotations

import pytest
from netgen import occ

from ngcell import read_case
from ngcell.build.simulation import Simulation
from ngcell.errors import CaseError
from ngcell.scene import Body, BodyScene, Cohesion, MooneyRivlin, Mortar

GOOD = ["cohesion.strength=0.05", "cohesion.energy=0.0015"]


def test_a_case_has_no_cohesion_unless_it_says_so():
    assert read_case("shear-empty-3x3").cohesion is None
    assert read_case("shear-empty-3x3", GOOD).cohesion == Cohesion(strength=0.05, energy=0.0015)


@pytest.mark.parametrize(
    "sets, says",
    [
        (["cohesion.strength=0.0", "cohesion.energy=1.0"], "cohesion.strength = 0.0"),
        (["cohesion.strength=1.0", "cohesion.energy=-1.0"], "cohesion.energy = -1.0"),
        (["cohesion.strength=1.0"], "cohesion.energy"),
        ([*GOOD, "cohesion.stiffness=1.0"], "cohesion.stiffness"),
        ([*GOOD, "contact.kind=mortar"], 'allowed: contact.kind = "penalty"'),
        ([*GOOD, "lumen.kind=fluid"], 'does not go with lumen.kind = "fluid"'),
    ],
)
def test_what_cannot_be_is_told(sets, says):
    with pytest.raises(CaseError) as error:
        read_case("shear-empty-3x3", sets)
    assert says in str(error.value)
    assert "allowed" in str(error.value)
    assert "\n" not in str(error.value).strip()


def test_walls_that_do_not_coincide_cannot_be_bonded():
    case = read_case("closing-rings", [*GOOD, "contact.kind=penalty"])
    with pytest.raises(CaseError, match="no walls coincide at rest"):
        _ = Simulation(case).released


def test_bodies_from_python_are_checked_too():
    material = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=20.0)
    body = Body(occ.MoveTo(0, 0).Rectangle(1, 1).Face(), material, "block")
    with pytest.raises(CaseError, match="cohesion"):
        BodyScene((body,), cohesion=0.1)  # type: ignore[arg-type]
    with pytest.raises(CaseError, match="a Penalty"):
        BodyScene((body,), cohesion=Cohesion(strength=1.0, energy=1.0), contact=Mortar())
