"""What a case may say about the strength of walls."""

from __future__ import annotations

import pytest

from ngcell import read_case
from ngcell.errors import CaseError

INCLUSION = "lumen={kind='inclusion', material={kind='mooney-rivlin', c1=1.0, c2=0.0, bulk_modulus=9.0, strength=1.0}}"


@pytest.mark.parametrize(
    "sets, says",
    [
        (["material.strength=0.0"], "material.strength = 0.0"),
        (["material.stretch_limit=1.0"], "material.stretch_limit = 1.0"),
        (["material.rupture_length=0.1"], "beside strength or stretch_limit"),
        (["material.strength=1.0", "material.rupture_length=0.0"], "material.rupture_length = 0.0"),
        (["material.strength=1.0", "tissue.height=1.0"], "only without tissue.height"),
        ([INCLUSION], "only in [material]"),
    ],
)
def test_what_cannot_be_is_told(sets, says):
    with pytest.raises(CaseError) as error:
        read_case("shear-empty-3x3", sets)
    assert says in str(error.value)
    assert "\n" not in str(error.value).strip()


def test_walls_have_no_strength_unless_it_is_said():
    material = read_case("shear-empty-3x3").material
    assert not material.ruptures and material.strength is None
    assert read_case("shear-empty-3x3", ["material.strength=0.3"]).material.ruptures
