"""A user's own contact method needs what the protocol names, and no more."""

from __future__ import annotations

import pytest

import ngcell
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness

_MULTIPLE = 30.0


class Plain:
    """A penalty that does not adapt, with the members of `ContactMethod` alone."""

    def __init__(self, inner: PenaltyContact, *, has_multipliers: bool = False) -> None:
        self._inner, self.has_multipliers = inner, has_multipliers
        self.walls, self.stiffness = inner.walls, inner.stiffness
        self.pair, self.couplings, self.pressures = inner.pair, inner.couplings, inner.pressures

    def follow(self, other, positions) -> None:
        pass

    def update_multipliers(self, contact, positions, stored) -> tuple[float, float]:
        return 0.0, 0.0

    def take_multipliers(self, keys, lowered) -> None:
        pass

    def note_kinks(self, contact, positions) -> bool:
        return False

    def increase_penalty(self) -> None:
        pass


class OwnContact:
    """Makes stages of these shares of a stiffness."""

    goes_with_cohesion = True

    def __init__(self, *shares: float, has_multipliers: bool = False) -> None:
        self._shares, self._has_multipliers = shares, has_multipliers

    def stages(self, walls, modulus_of_body, *, reach, options):
        stiffness = penalty_stiffness(walls, modulus_of_body, _MULTIPLE)
        penalties = [PenaltyContact(walls, share * stiffness, reach, may_stiffen=False) for share in self._shares]
        return tuple(Plain(penalty, has_multipliers=self._has_multipliers) for penalty in penalties)


def solved(contact, *changes: str):
    small = ["tissue.rows=2", "tissue.cols=2", "load.displacement=[0.1, 0.0]", "load.levels=1", "accuracy=0.1"]
    case = ngcell.read_case("shear-empty-3x3", [*small, *changes])
    *_, last = ngcell.simulate(case.model_copy(update={"contact": contact, "expected": ()}))
    return last.record


@pytest.mark.parametrize("shares", [(1.0,), (0.1, 1.0)])
def test_a_method_is_what_the_protocol_names(shares):
    mine, theirs = solved(OwnContact(*shares)), solved(ngcell.Penalty())
    assert mine.certified and theirs.certified
    assert mine.energy == pytest.approx(theirs.energy, rel=0.02)


def test_multipliers_need_a_stage_that_leads_to_them():
    with pytest.raises(ngcell.CaseError, match="one stage has multipliers"):
        solved(OwnContact(1.0, has_multipliers=True))


def test_a_law_that_is_no_function_is_refused_in_words():
    with pytest.raises(ngcell.CaseError, match="law = None; allowed: a function"):
        ngcell.NormalLaw(None)
