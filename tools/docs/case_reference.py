"""The case reference: every table of a case file and its entries, from the JSON schema.

Types, limits, defaults and meanings are the schema's.
"""

from __future__ import annotations

from typing import Any

from ngcell.scene import schema
from ngcell.scene.meanings import described

_LIMITS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
_INTRODUCTION = """# Case reference

Every table of a case file with its entries, made from the schema that `ngcell schema` prints. Where no default is
shown, the meaning says what holds without the entry. How the tables go together: [cases](../cases.md),
[own bodies](../bodies.md).

"""

Schema = dict[str, Any]


def case_reference() -> str:
    """Return the page, in Markdown."""
    tables = schema()["$defs"]
    first = ["Case", "BodyCase"]
    names = [*first, *sorted(tables.keys() - set(first))]
    return _INTRODUCTION + "\n".join(_table(name, tables[name]) for name in names)


def _table(name: str, table: Schema) -> str:
    kind = table["properties"].get("kind", {}).get("const")
    about, _ = described(table.get("description", ""))
    rows = [
        f"| `{entry}` | {_cell(what.get('description', ''))} "
        f"| {_type(what)} | {_default(what, entry in table.get('required', []))} |"
        for entry, what in table["properties"].items()
        if entry != "kind"
    ]
    heading = f"## {name}" + (f': `kind = "{kind}"`' if kind else "")
    listed = "\n".join(["| entry | meaning | type | default |", "|---|---|---|---|", *rows]) if rows else "No entries."
    return f"({_label(name)})=\n\n{heading}\n\n{about}\n\n{listed}\n"


def _type(what: Schema) -> str:
    """Return type and limits of an entry, with links to tables."""
    for several in ("anyOf", "oneOf"):
        if several in what:
            told = [_type(one) for one in what[several] if one.get("type") != "null"]
            return ", or ".join(dict.fromkeys(told))
    if "$ref" in what:
        name = what["$ref"].rpartition("/")[2]
        return f"[{name}](#{_label(name)})"
    if "enum" in what or "const" in what:
        return ", ".join(f'`"{value}"`' for value in what.get("enum", [what.get("const")]))
    if what.get("type") == "array":
        parts = what.get("prefixItems")
        return f"list of {len(parts)} numbers" if parts else f"list of: {_type(what.get('items', {}))}"
    limits = ", ".join(f"{sign} {what[key]:g}" for key, sign in _LIMITS.items() if key in what)
    return f"{what.get('type', 'any')} {limits}".strip()


def _default(what: Schema, required: bool) -> str:
    value = what.get("default")
    if required or value is None or isinstance(value, dict | list) or value == "":
        return "required" if required else ""
    return f'`"{value}"`' if isinstance(value, str) else f"`{str(value).lower()}`"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")


def _label(name: str) -> str:
    return f"table-{name.lower()}"
