"""What a case file may say: its JSON schema and, read off the schema, the words for what is allowed."""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import TypeAdapter

from ngcell.scene.accuracy import OR_INFINITE
from ngcell.scene.choice import DEFAULT_KIND
from ngcell.scene.kinds import AnyCase, kind_of_case
from ngcell.scene.lines import KeyPath
from ngcell.scene.registry import registered
from ngcell.scene.study import Study

Node = dict[str, Any]

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def _schema() -> Node:
    return _schema_of(registered())


def _definitions() -> dict[str, Node]:
    study = schema_of_study()
    return {**_schema()["$defs"], **study["$defs"], Study.__name__: study}


@cache
def _schema_of_study(own_kinds: tuple[type, ...]) -> Node:
    return TypeAdapter(Study).json_schema()


@cache
def _schema_of(own_kinds: tuple[type, ...]) -> Node:
    """Return the schema while scripts have registered these kinds."""
    return TypeAdapter(AnyCase).json_schema()


def schema() -> Node:
    """Return the JSON schema of a whole case of either kind; that which editors read is made of it."""
    return {"$schema": DRAFT, **_schema()}


def schema_of_study() -> Node:
    """Return the JSON schema of a study whose axes all are tables with a kind."""
    return _schema_of_study(registered())


def node_at(path: KeyPath, table: Any, section: str | None = None) -> Node:
    """Return the schema of the key at `path`; `table`, what the file says, tells the kinds on the way.

    The file is a case, or else the section of that name.
    """
    node: Node = _definitions()[section or kind_of_case(table).__name__]
    for part in path:
        table = _entry(table, part)
        node = _resolved(_below(node, part), table)
    return node


def keys(node: Node) -> list[str]:
    """Return the keys of a table."""
    return list(node.get("properties", ()))


def kinds(node: Node) -> list[str]:
    """Return the kinds between which a table chooses."""
    return list(node.get("discriminator", {}).get("mapping", ()))


def allowed(node: Node) -> str:
    """Return in words what a key may be."""
    if "anyOf" in node:
        return " or ".join(allowed(_resolved(option, None)) for option in node["anyOf"])
    if "const" in node or "enum" in node:
        values = node.get("enum", [node.get("const")])
        return ("one of " if len(values) > 1 else "") + ", ".join(f'"{value}"' for value in values)
    if node.get("type") == "array":
        return _array(node)
    nouns = {"integer": "a whole number", "number": "a finite number", "string": "text in quotes"}
    rest = ", or inf" if node.get("format") == OR_INFINITE else ""
    return nouns.get(node.get("type", ""), "a table") + _limits(node) + rest


def _array(node: Node) -> str:
    items = node.get("prefixItems")
    if items is None:
        return f"a list, each entry {allowed(_resolved(node['items'], None))}"
    return f"[{', '.join(allowed(_resolved(item, None)) for item in items)}]"


def _limits(node: Node) -> str:
    if "minimum" in node and "maximum" in node:
        return f" from {node['minimum']:g} to {node['maximum']:g}"
    signs = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
    limits = [f" {sign} {node[key]:g}" for key, sign in signs.items() if key in node]
    return " and".join(limits) + _of_text(node)


def _of_text(node: Node) -> str:
    if "pattern" in node:  # the only one there is: that of names
        return " of letters, digits, _ and -"
    return ", not empty" if node.get("minLength") else ""


def _resolved(node: Node, table: Any) -> Node:
    """Return the schema behind references, "or nothing" and a choice by kind."""
    if "$ref" in node:
        return _resolved(_definitions()[node["$ref"].rpartition("/")[2]], table)
    options = [option for option in node.get("anyOf", ()) if option.get("type") != "null"]
    if len(options) == 1:
        return _resolved(options[0], table)
    kind = _entry(table, "kind") or node.get(DEFAULT_KIND)
    chosen = node.get("discriminator", {}).get("mapping", {}).get(kind) if isinstance(kind, str) else None
    return _resolved({"$ref": chosen}, table) if chosen else node


def _below(node: Node, part: str | int) -> Node:
    entries: dict[str | int, Node] = {
        **node.get("properties", {}),
        **dict(enumerate(node.get("prefixItems", ()))),
    }
    other: Node = node.get("items") or node.get("additionalProperties") or {}
    return entries.get(part, other)


def _entry(table: Any, part: str | int) -> Any:
    if isinstance(table, dict):
        return table.get(part)
    return table[part] if isinstance(table, list) and isinstance(part, int) and part < len(table) else None
