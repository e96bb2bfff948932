"""The JSON schemas that editors complete and check files with: what they let pass, where they mark a mistake, what they
offer."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from ngcell.scene import shipped_cases
from ngcell.scene.editor_schema import case_schema, study_schema

SCHEMA = case_schema()
SHELF = min((file.parent for file in shipped_cases().values()), key=lambda folder: len(folder.parts))
STUDIES = SHELF / "studies"
FILES = sorted(SHELF.rglob("*.toml"))


def marked(value: Any, schema: dict[str, Any] = SCHEMA) -> set[str]:
    """Return the dotted keys at which a validator finds something wrong."""
    as_json = json.loads(json.dumps(value), parse_constant=lambda word: None)  # editors take TOML's `inf` for null
    return {".".join(map(str, error.absolute_path)) for error in Draft202012Validator(schema).iter_errors(as_json)}


def fits(value: Any) -> bool:
    """Return whether a case is as the schema says."""
    return not marked(value)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_shipped_files_fit(file: Path) -> None:
    schema = study_schema() if file.parent == STUDIES else SCHEMA
    assert marked(tomllib.loads(file.read_text(encoding="utf-8")), schema) == set()


WHOLE = {
    "tissue": {"rows": 1, "cols": 2, "wall": 0.1},
    "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
    "load": {"kind": "plates", "displacement": [0.1, 0.0], "levels": 1},
}


@pytest.mark.parametrize("part", [{}, {"tissue": {"wall": 0.2}}, {"load": {"levels": 3}}, {"mesh": {"order": 2}}])
def test_a_case_that_extends_another_says_any_part(part: dict[str, Any]) -> None:
    assert fits(WHOLE)
    assert fits({"extends": "shear-empty", **part})
    assert not fits(part)
    assert not fits({"extends": 3, **part})
    assert not fits({"extends": "shear-empty", **part, "tisue": {}})
    assert not fits({"extends": "shear-empty", **part, "material": {"c1": "soft"}})


def changed(section: str, **entries: Any) -> dict[str, Any]:
    return WHOLE | {section: {**WHOLE.get(section, {}), **entries}}


@pytest.mark.parametrize(
    ("case", "place"),
    [
        (changed("tissue", wall=-0.1), "tissue.wall"),
        (changed("tissue", rows="three"), "tissue.rows"),
        (changed("tissue", colour=3), "tissue"),
        (changed("tissue", file="cells.csv"), "tissue.file"),
        (changed("load", kind="plate"), "load.kind"),
        (changed("load", shear=0.1), "load"),
        (changed("lumen", kind="pressure", pressure="high"), "lumen.pressure"),
        (changed("mesh", order=0), "mesh.order"),
        (changed("mesh", refine=[]), "mesh"),
        (WHOLE | {"tisue": {}}, "tisue"),
        (WHOLE | {"supports": []}, "supports"),
        (WHOLE | {"accuracy": -1.0}, "accuracy"),
        (WHOLE | {"tissue": {"rows": 1, "cols": 1}}, "tissue"),
        (WHOLE | {"material": {"c1": 1.0}}, "material"),
        ({"extends": "shear-empty", "mesh": {"ordr": 2}}, "mesh"),
        ({"extends": "shear-empty", "load": {"levels": 0}}, "load.levels"),
        ({"extends": "press-fit", "bodies": [{"name": "ring", "radius": "large"}]}, "bodies.0.radius"),
        ({"bodies": [{"kind": "disc", "name": "a"}], "tissue": {}}, "tissue"),
    ],
)  # fmt: skip
def test_a_mistake_is_marked_where_it_is_and_nowhere_else(case: dict[str, Any], place: str) -> None:
    found = marked(case)
    assert place in found and "" not in found
    assert all(one.startswith(place) or place.startswith(one) or one.startswith("bodies") for one in found)


def node_at(path: tuple[str, ...], node: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    """Return what editors find at a path: by references, properties and entries of lists only, as they all do."""
    if "$ref" in node:
        node = schema["$defs"][node["$ref"].rpartition("/")[2]] | {key: node[key] for key in node.keys() - {"$ref"}}
    if not path:
        return node
    return node_at(path[1:], node["items"] if path[0] == "0" else node["properties"][path[0]], schema)


@pytest.mark.parametrize(
    ("path", "keys"),
    [
        ("", {"tissue", "material", "load", "bodies", "extends", "accuracy"}),
        ("tissue", {"kind", "rows", "wall", "file"}),
        ("material", {"kind", "c1", "bulk_modulus", "fibres"}),
        ("lumen.material.fibres", {"kind", "stiffness"}),
        ("load", {"displacement", "levels", "shape"}),
        ("mesh", {"order", "size", "refine"}),
        ("expected.0", {"level", "quantity", "boundary"}),
        ("bodies.0", {"kind", "name", "radius"}),
    ],
)
def test_editors_find_the_keys_to_offer(path: str, keys: set[str]) -> None:
    node = node_at(tuple(path.split(".")) if path else (), SCHEMA, SCHEMA)
    assert keys <= node["properties"].keys()
    assert "allOf" not in node and "oneOf" not in node, "beside these Taplo offers nothing, or marks every line"


def test_every_key_that_is_offered_says_what_it_means() -> None:
    tables = {"": SCHEMA, **SCHEMA["$defs"]}
    silent = [
        f"{name}.{entry}"
        for name, table in tables.items()
        for entry, what in table["properties"].items()
        if entry != "kind" and not what.get("description")
    ]
    assert silent == []
    assert "kind" in SCHEMA["$defs"]["Ends-or-Frame-or-Indenter-or-Plates"]["properties"]
    assert node_at(("load", "sides"), SCHEMA, SCHEMA)["enum"] == ["free", "confined"]
    assert node_at(("load", "shear"), SCHEMA, SCHEMA)["description"].startswith("(frame) ")


def test_an_infinite_accuracy_fits_as_editors_read_it() -> None:
    assert fits(WHOLE | {"accuracy": None}) and fits(WHOLE | {"accuracy": 0.1})
    assert not fits(WHOLE | {"accuracy": "fine"})


@pytest.mark.parametrize(
    ("axes", "places"),
    [
        ({"tissue": {"wall": [0.1, 0.2], "kind": ["honeycomb", "brick"]}}, set()),
        ({"material": {"fibres": {"stiffness": {"kind": "range", "start": 0.1, "stop": 1.0, "number": 3}}}}, set()),
        ({"tissue": {"wall": {"kind": "range", "start": 0.1, "stp": 1.0, "number": 3}}}, {"axes.tissue.wall"}),
        ({"both": {"kind": "zap", "values": {}}}, {"axes.both"}),
        ({"tissue": {"wall": 3}}, {"axes.tissue.wall"}),
    ],
)
def test_axes_of_studies_are_checked_where_they_are(axes: dict[str, Any], places: set[str]) -> None:
    found = marked({"case": "shear-empty", "axes": axes}, study_schema())
    assert bool(found) == bool(places) and all(any(one.startswith(place) for place in places) for one in found)


def test_the_schema_that_comes_with_the_cases_is_that_of_the_package() -> None:
    told = "the schema has changed: ngcell schema --out cases/case.schema.json"
    assert json.loads((SHELF / "case.schema.json").read_text(encoding="utf-8")) == SCHEMA, told


def test_the_schema_that_comes_with_the_studies_is_that_of_the_package() -> None:
    told = "the schema has changed: ngcell schema --study --out cases/studies/study.schema.json"
    shipped = json.loads((STUDIES / "study.schema.json").read_text(encoding="utf-8"))
    assert shipped == json.loads(json.dumps(study_schema())), told


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_case_files_begin_with_their_schema(file: Path) -> None:
    word, place = file.read_text(encoding="utf-8").splitlines()[0].split()
    schema = STUDIES / "study.schema.json" if file.parent == STUDIES else SHELF / "case.schema.json"
    assert word == "#:schema" and (file.parent / place).resolve() == schema.resolve()
