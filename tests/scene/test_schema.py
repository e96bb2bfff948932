"""The JSON schema that editors check case files with: what it lets pass, and what not."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from ngcell.scene import schema, shipped_cases

SCHEMA = schema()
TYPES = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "null": type(None)}


def fits(value: Any, node: dict[str, Any]) -> bool:
    """Return whether a value is as a schema says, as far as the keywords go that are used here."""
    if "$ref" in node and not fits(value, SCHEMA["$defs"][node["$ref"].rpartition("/")[2]]):
        return False
    if "if" in node and not fits(value, node["then"] if fits(value, node["if"]) else node["else"]):
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
