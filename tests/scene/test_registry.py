"""The registry: kinds of a script in case files and from Python, and objects that only offer what is needed."""

from __future__ import annotations

from typing import Literal

import ngsolve
import pytest
from pydantic import BaseModel, ConfigDict

import ngcell
from ngcell.errors import CaseError
from ngcell.scene import Body, BodyScene, Case, read_case, registry, resolved_toml, schema
from tests.scene.conftest import GOOD


class Foam(BaseModel):
    """A law of a script: a neo-Hookean solid that names its constants differently."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["foam"] = "foam"
    stiffness: float


@pytest.fixture
def foam():
    ngcell.register("material", Foam)
    yield Foam
    del registry.group("material").own["foam"]


def case_of(tmp_path, material: str):
    head, _, tail = GOOD.partition("[material]")
    file = tmp_path / "case.toml"
    file.write_text(f"{head}[material]\n{material}\n\n[load]{tail.partition('[load]')[2]}")
    return file


def test_a_registered_kind_is_read_checked_and_written(foam, tmp_path):
    read_case("shear-empty")  # kinds may come after the first validation
    file = case_of(tmp_path, 'kind = "foam"\nstiffness = 2.0')
    case = read_case(file)
    assert case.material == foam(stiffness=2.0)
    file.write_text(resolved_toml(case))
    assert read_case(file) == case
    with pytest.raises(CaseError, match=r"case\.toml:10: material\.kind = \"foma\" is not possible; did you mean foam"):
        read_case(case_of(tmp_path, 'kind = "foma"'))
    with pytest.raises(CaseError, match=r"material\.stifness = 1.0 is unknown; did you mean stiffness"):
        read_case(case_of(tmp_path, 'kind = "foam"\nstifness = 1.0'))


def test_the_schema_lists_kinds_as_they_are_registered(foam):
    kinds = schema()["$defs"]["Case"]["properties"]["material"]["discriminator"]["mapping"]
    assert set(kinds) == {"foam", "mooney-rivlin"}
    del registry.group("material").own["foam"]
    assert set(schema()["$defs"]["Case"]["properties"]["material"]["discriminator"]["mapping"]) == {"mooney-rivlin"}
    ngcell.register("material", foam)


@pytest.mark.parametrize("name", sorted(registry.section_names()))
def test_every_kind_of_the_package_is_a_frozen_section_that_names_itself(name):
    section = registry.section_named(name)
    assert section.model_config["frozen"] and section.model_config["extra"] == "forbid"
    assert isinstance(section.model_fields["kind"].default, str)
    assert section.__doc__


def test_objects_that_offer_what_a_law_needs_take_its_place():
    law = ngcell.CustomLaw(lambda f: 0.5 * (ngsolve.Trace(f.trans * f) - 3) - ngsolve.log(ngsolve.Det(f)))
    tables = {"tissue": {"rows": 1, "cols": 2, "wall": 0.1}, "load": {"kind": "plates", "stretch": 1.1}}
    case = Case(material=law, **tables)
    assert case.material is law
    assert 'kind = "ngcell.mechanics.laws.custom:CustomLaw"' in resolved_toml(case)
    assert BodyScene([Body(object(), law, "block")]).bodies[0].material is law
    with pytest.raises(
        CaseError, match="allowed: a MooneyRivlin, or an object that offers bulk_modulus, cauchy_stress"
    ):
        Body(object(), object(), "block")


@pytest.mark.parametrize(
    ("group", "section", "says"),
    [
        ("materials", Foam, "'materials' is no group of kinds; did you mean material?"),
        ("material", dict, "names no kind of material; allowed: a pydantic model with a field"),
        ("material", ngcell.MooneyRivlin, "material kind 'mooney-rivlin' is one of the package"),
    ],
)
def test_what_cannot_be_registered(group, section, says):
    with pytest.raises(CaseError) as caught:
        ngcell.register(group, section)
    assert says in str(caught.value)
