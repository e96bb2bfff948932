"""The JSON schema that editors check case files with: what it lets pass, and what not."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

from ngcell.scene import schema, shipped_cases
from ngcell.scene.vocabulary import study_schema

SCHEMA = schema()
TYPES = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "null": type(None)}


def fits(value: Any, node: dict[str, Any]) -> bool:
    """Return whether a value is as a schema says, as far as the keywords go that are used here."""
    if "$ref" in node and not fits(value, SCHEMA["$defs"][node["$ref"].rpartition("/")[2]]):
        return False
    if "anyOf" in node and not any(fits(value, option) for option in node["anyOf"]):
        return False
    if "oneOf" in node and sum(fits(value, option) for option in node["oneOf"]) != 1:
        return False
    if "const" in node and value != node["const"] or "enum" in node and value not in node["enum"]:
        return False
    if "type" in node and not isinstance(value, TYPES[node["type"]]):
        return False
    if isinstance(value, dict):
        known = node.get("properties", {})
        unknown = value.keys() - known.keys() if node.get("additionalProperties") is False else set()
        asked_for = value.keys() >= set(node.get("required", ()))
        return asked_for and not unknown and all(fits(value[key], known[key]) for key in value.keys() & known.keys())
    return not isinstance(value, list) or all(fits(entry, node.get("items", {})) for entry in value)


@pytest.mark.parametrize("name", shipped_cases())
def test_shipped_cases_fit(name):
    assert fits(tomllib.loads(shipped_cases()[name].read_text(encoding="utf-8")), SCHEMA)


WHOLE = {
    "tissue": {"rows": 1, "cols": 2, "wall": 0.1},
    "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
    "load": {"kind": "plates", "displacement": [0.1, 0.0], "levels": 1},
}


@pytest.mark.parametrize("part", [{}, {"tissue": {"wall": 0.2}}, {"load": {"levels": 3}}, {"mesh": {"order": 2}}])
def test_a_case_that_extends_another_says_any_part(part):
    assert fits(WHOLE, SCHEMA)
    assert fits({"extends": "shear-empty", **part}, SCHEMA)
    assert not fits(part, SCHEMA)
    assert not fits({"extends": 3, **part}, SCHEMA)
    assert not fits({"extends": "shear-empty", **part, "tisue": {}}, SCHEMA)
    assert not fits({"extends": "shear-empty", **part, "material": {"c1": "soft"}}, SCHEMA)


def offered(path: tuple[str, ...], node: dict[str, Any]) -> set[str]:
    """Return the keys that an editor offers below a path: by references, choices and properties, as they all do."""
    if "$ref" in node:
        return offered(path, SCHEMA["$defs"][node["$ref"].rpartition("/")[2]])
    found = set().union(*(offered(path, option) for word in ("anyOf", "oneOf") for option in node.get(word, ())))
    known = node.get("properties", {})
    if not path:
        return found | set(known)
    return found | (offered(path[1:], known[path[0]]) if path[0] in known else set())


@pytest.mark.parametrize(
    ("path", "keys"),
    [
        ((), {"tissue", "material", "load", "bodies", "extends", "accuracy"}),
        (("tissue",), {"kind", "rows", "wall"}),
        (("material",), {"kind", "c1", "bulk_modulus"}),
        (("mesh",), {"order", "size"}),
    ],
)
def test_editors_find_the_keys_to_offer(path: tuple[str, ...], keys: set[str]) -> None:
    assert keys <= offered(path, SCHEMA)


def test_an_infinite_accuracy_fits_as_editors_read_it() -> None:
    assert fits(WHOLE | {"accuracy": None}, SCHEMA) and fits(WHOLE | {"accuracy": 0.1}, SCHEMA)
    assert not fits(WHOLE | {"accuracy": "fine"}, SCHEMA)


SHELF = min((file.parent for file in shipped_cases().values()), key=lambda folder: len(folder.parts))
STUDIES = SHELF / "studies"
FILES = sorted(SHELF.rglob("*.toml"))


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
