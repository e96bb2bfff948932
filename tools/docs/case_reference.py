"""The case reference: every table of a case file and its entries, from the JSON schema.

Types, limits and defaults are the schema's. What an entry means is in the docstring of its table, whose parameters are
the entries, or in that of a class that it shares them with.
"""

from __future__ import annotations

import re
from inspect import cleandoc
from typing import Any

import ngcell
from ngcell.scene import schema

_SHARED = re.compile(r"those of `ngcell\.[\w.]+`")
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
    names = [*first, *sorted(name for name in tables if name not in first and not name.endswith("InPart"))]
    return _INTRODUCTION + "\n".join(_table(name, tables[name]) for name in names)


def _table(name: str, table: Schema) -> str:
    kind = table["properties"].get("kind", {}).get("const")
    about, _ = described(table.get("description", ""))
    told = meanings(name, table)
    rows = [
        f"| `{entry}` | {_cell(told.get(entry, ''))} "
        f"| {_type(what)} | {_default(what, entry in table.get('required', []))} |"
        for entry, what in table["properties"].items()
        if entry != "kind"
    ]
    heading = f"## {name}" + (f': `kind = "{kind}"`' if kind else "")
    listed = "\n".join(["| entry | meaning | type | default |", "|---|---|---|---|", *rows]) if rows else "No entries."
    return f"({_label(name)})=\n\n{heading}\n\n{about}\n\n{listed}\n"


def described(text: str) -> tuple[str, dict[str, str]]:
    """Return what a docstring says of a table, and what of each of its entries."""
    about, _, rest = text.partition("\nParameters\n----------\n")
    section = re.split(r"\n\n\w+\n-+\n", rest)[0]
    found = re.findall(r"^(\w+(?:, \w+)*) : [^\n]*\n((?:(?: +[^\n]*)?\n?)*)", section, flags=re.MULTILINE)
    told = {entry: " ".join(meaning.split()) for entries, meaning in found for entry in entries.split(", ")}
    return _SHARED.sub("those below", about.strip()), told


def meanings(name: str, table: Schema) -> dict[str, str]:
    """Return what is said of each entry of a table: by itself, or by a class that it shares entries with."""
    parents = getattr(ngcell, name, object).__mro__[:0:-1]
    texts = [cleandoc(parent.__doc__ or "") for parent in parents if parent.__module__.startswith("ngcell.")]
    told = (described(text)[1] for text in (*texts, table.get("description", "")))
    return {entry: meaning for each in told for entry, meaning in each.items()}


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
