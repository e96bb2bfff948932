"""The JSON schemas that editors complete and check case files and studies with.

Two things are kept apart. A *shape* says which keys a table may have and what their values may be; it holds for every
file, and editors find in it, by `$ref`, `properties` and `items` alone, what to offer and what it means. *Needs* say
what has to be there; they hold for files that extend no other. Choices are made by `if` and never by `oneOf`: so a
mistake is marked where it is, and not on every line of the file. Taplo, the language server that editors have for TOML,
offers no keys of a table beside whose `properties` there is an `allOf`, and follows no reference below
`additionalProperties`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from ngcell.scene.accuracy import OR_INFINITE
from ngcell.scene.choice import DEFAULT_KIND
from ngcell.scene.meanings import described
from ngcell.scene.vocabulary import DRAFT, Node, schema, schema_of_study

#: The key of a case file that is none of a case: it names the case that the file extends.
EXTENDS = "extends"
_INHERITED = {"type": "string", "description": "Case whose keys are taken over: its path from this file, or its name."}
_DROPPED = {"title", "discriminator", "oneOf", "required", DEFAULT_KIND}
_KIND = "kind"
#: What the value is of a key that does not belong there; unlike `false` it marks the key, and not the whole table.
_NO_KEY: Node = {"enum": ["nothing: there is no such key here"]}
#: Where the first sentence of what a table is ends.
_SENTENCE = re.compile(r"\n\n|; its keys are ")
#: How many tables a dotted key of an axis may lead through.
_DEPTH = 4


def case_schema() -> Node:
    """Return the JSON schema of a case file of either kind."""
    tables = _Tables(schema()["$defs"])
    names = {"tissues": "Case", "own bodies": "BodyCase"}
    shapes = {label: tables.shape(tables.raw[name]) for label, name in names.items()}
    for shape in shapes.values():
        shape["properties"] = {EXTENDS: _INHERITED, **shape["properties"]}
    tissue, bodies = shapes.values()
    top = _either(shapes, tables.defined)
    is_of_bodies, extends = {"required": ["bodies"]}, {"required": [EXTENDS]}
    of_tissue, of_bodies = (tables.needs(tables.raw[name]) for name in names.values())
    whole_bodies = {"allOf": [_alone(bodies, top), _unless(extends, of_bodies)]}
    whole_tissue = _unless(extends, {"allOf": [_alone(tissue, top), of_tissue]})
    rules = {"if": is_of_bodies, "then": whole_bodies, "else": whole_tissue}
    return {"$schema": DRAFT, "$defs": tables.defined, **top, "additionalProperties": _NO_KEY, **rules}


def study_schema() -> Node:
    """Return the JSON schema of a study: an axis is also a list, or a table of tables, as TOML reads a dotted key."""
    study = schema_of_study()
    tables = _Tables(study["$defs"])
    chosen = study["properties"]["axes"]["additionalProperties"]["discriminator"]["mapping"]
    kinds = {kind: tables.raw[_name(ref)] for kind, ref in chosen.items()}
    lists = {"type": ["array", "object"]}
    shapes = {kind: tables.shape(table) for kind, table in kinds.items()}
    for kind, entry in (("zip", "values"), ("latin-hypercube", "over")):
        shapes[kind]["properties"][entry]["additionalProperties"] = lists
    is_text = {"type": "object", "properties": {_KIND: {"type": "string"}}, "required": [_KIND]}
    known = {"enum": list(kinds), "description": _told(shapes)}
    told = {name: {"description": entry["description"]} for name, entry in _either(shapes, {})["properties"].items()}
    rules = [(_is(kind), {"allOf": [shapes[kind], tables.needs(kinds[kind])]}) for kind in kinds]
    axis: Node = lists
    for _ in range(_DEPTH):
        axis = {
            "type": ["array", "object"],
            "description": "A list of values, or a kind of axis.",
            "properties": {**told, _KIND: {"description": known["description"], "anyOf": [known, lists]}},
            **_first_of(rules, _unless(is_text, {"additionalProperties": axis})),
        }
    shape = tables.shape(study)
    shape["properties"]["axes"]["additionalProperties"] = axis
    return {"$schema": DRAFT, "$defs": tables.defined, **shape, "required": study["required"]}


class _Tables:
    """Shapes and needs of tables.

    Parameters
    ----------
    raw : mapping of str to Node
        The schema of each table, as the validating library tells it.

    Attributes
    ----------
    defined : dict of str to Node
        The shapes that others refer to, by name.
    """

    def __init__(self, raw: Mapping[str, Node]) -> None:
        self.raw, self.defined = raw, dict[str, Node]()

    def shape(self, node: Node) -> Node:
        """Return which keys and values there may be."""
        told = {key: node[key] for key in ("description", "default") if _is_told(node.get(key))}
        if "$ref" in node:
            return {**self._defined(_name(node["$ref"])), **told}
        if "discriminator" in node:
            return {**self._choice(node), **told}
        options = [option for option in node.get("anyOf", ()) if option.get("type") != "null"]
        if options:
            shapes = [self.shape(option) for option in options]
            return {**(shapes[0] if len(shapes) == 1 else {"anyOf": shapes}), **told}
        if node.get("format") == OR_INFINITE:  # editors take TOML's `inf` for null: JSON has no word for it
            limits = {key: value for key, value in node.items() if key not in (*_DROPPED, *told)}
            return {**told, "anyOf": [limits, {"type": "null"}]}
        kept = {key: value for key, value in node.items() if key not in (*_DROPPED, "default")} | told
        if "properties" in node:
            kept["description"] = described(node.get("description", ""))[0]
            kept["properties"] = {entry: self.shape(what) for entry, what in node["properties"].items()}
        if "items" in node:
            kept["items"] = self.shape(node["items"])
        return kept

    def needs(self, node: Node) -> Node:
        """Return what has to be there; empty where nothing has."""
        if "$ref" in node:
            return self.needs(self.raw[_name(node["$ref"])])
        if "discriminator" in node:
            kinds = {kind: self.raw[_name(ref)] for kind, ref in node["discriminator"]["mapping"].items()}
            rules = [{"if": _is(kind), "then": needs} for kind, one in kinds.items() if (needs := self.needs(one))]
            default = kinds.get(node.get(DEFAULT_KIND, ""))
            if default is None:
                return {"required": [_KIND], **({"allOf": rules} if rules else {})}
            others = {entry for table in kinds.values() for entry in table["properties"]} - default["properties"].keys()
            plain = {"properties": dict.fromkeys(sorted(others), _NO_KEY)}
            return {"allOf": [*rules, _unless({"required": [_KIND]}, {"allOf": [plain, self.needs(default)]})]}
        options = [option for option in node.get("anyOf", ()) if option.get("type") != "null"]
        if len(options) == 1:
            return self.needs(options[0])
        inside = {entry: needs for entry, what in node.get("properties", {}).items() if (needs := self.needs(what))}
        items = self.needs(node.get("items", {})) if node else {}
        said = {"required": node.get("required"), "properties": inside, "items": items}
        return {key: value for key, value in said.items() if value}

    def _defined(self, name: str) -> Node:
        if name not in self.defined:
            self.defined[name] = {}
            self.defined[name] = self.shape(self.raw[name])
        return _ref(name)

    def _choice(self, node: Node) -> Node:
        """Define the shape of a table whose key `kind` chooses what its other keys are."""
        kinds = {kind: _name(ref) for kind, ref in node["discriminator"]["mapping"].items()}
        name = "-or-".join(kinds.values())
        if name not in self.defined:
            self.defined[name] = {}
            shapes = {kind: self.shape(self.raw[table]) for kind, table in kinds.items()}
            union = _either(shapes, self.defined)
            kind = {"type": "string", "enum": list(kinds), "description": _told(shapes)}
            if DEFAULT_KIND in node:
                kind["default"] = node[DEFAULT_KIND]
            union["properties"] = {_KIND: kind, **union["properties"]}
            rules = [(_is(kind), _only(shape, union)) for kind, shape in shapes.items()]
            known = {"properties": dict.fromkeys(union["properties"], {}), "additionalProperties": False}
            del union["additionalProperties"]
            self.defined[name] = {"description": _told(shapes), **union, **_first_of(rules, known)}
        return _ref(name)


def _either(shapes: Mapping[str, Node], defined: Mapping[str, Node]) -> Node:
    """Return a shape that every table of these shapes has; each key tells of which of them it is."""
    entries = dict.fromkeys(entry for shape in shapes.values() for entry in shape["properties"] if entry != _KIND)
    found = {}
    for entry in entries:
        of = {label: shape["properties"][entry] for label, shape in shapes.items() if entry in shape["properties"]}
        found[entry] = {**_merged(of, defined), "description": _meaning(of, everywhere=len(of) == len(shapes))}
    return {"type": "object", "properties": found, "additionalProperties": False}


def _merged(variants: Mapping[str, Node], defined: Mapping[str, Node]) -> Node:
    """Return a shape that each value of one of these shapes has."""
    bare = {label: _bare(variant) for label, variant in variants.items()}
    first = next(iter(bare.values()))
    if all(variant == first for variant in bare.values()):
        return first
    tables = {label: defined[_name(one["$ref"])] if "$ref" in one else one for label, one in bare.items()}
    if all("properties" in table for table in tables.values()):
        return _either(tables, defined)
    if all("items" in table for table in tables.values()):
        return {"type": "array", "items": _merged({label: table["items"] for label, table in tables.items()}, defined)}
    types = {str(table.get("type", "")) for table in tables.values()}
    common: Node = {"type": types.pop()} if len(types) == 1 and "" not in types else {}
    if all("enum" in table for table in tables.values()):
        common["enum"] = list(dict.fromkeys(value for table in tables.values() for value in table["enum"]))
    return common


def _only(shape: Node, union: Node) -> Node:
    """Return what one of several shapes says beyond what they say together."""
    common = union["properties"]
    entries = {
        entry: {} if entry == _KIND or _bare(what) == _bare(common[entry]) else what
        for entry, what in shape["properties"].items()
    }
    return {"properties": entries, "additionalProperties": False}


def _alone(shape: Node, union: Node) -> Node:
    """Return the same of the file as a whole, where a key of another shape is marked itself."""
    others = dict.fromkeys(union["properties"].keys() - shape["properties"].keys(), _NO_KEY)
    return {"properties": {**_only(shape, union)["properties"], **dict(sorted(others.items()))}}


def _meaning(of: Mapping[str, Node], *, everywhere: bool) -> str:
    """Return the meaning of a key, which may differ between tables that have it."""
    labels: dict[str, list[str]] = {}
    for label, what in of.items():
        labels.setdefault(what.get("description", ""), []).append(label)
    if len(labels) == 1:
        (text,) = labels
        return text if everywhere else f"({', '.join(of)}) {text}"
    return " ".join(f"({', '.join(names)}) {text}" for text, names in labels.items())


def _told(shapes: Mapping[str, Node]) -> str:
    """Return what each kind is, in a sentence."""
    firsts = ((kind, _SENTENCE.split(shape.get("description", ""))[0]) for kind, shape in shapes.items())
    return "\n\n".join(f"`{kind}`: {' '.join(first.split())}" for kind, first in firsts)


def _bare(node: Node) -> Node:
    return {key: value for key, value in node.items() if key not in ("description", "default")}


def _is(kind: str) -> Node:
    return {"type": "object", "properties": {_KIND: {"const": kind}}, "required": [_KIND]}


def _unless(condition: Node, rule: Node) -> Node:
    return {"if": condition, "then": {}, "else": rule}


def _first_of(rules: Iterable[tuple[Node, Node]], otherwise: Node) -> Node:
    """Return the rule whose condition is the first that holds."""
    found = otherwise
    for condition, rule in list(rules)[::-1]:
        found = {"if": condition, "then": rule, "else": found}
    return found


def _ref(name: str) -> Node:
    return {"$ref": f"#/$defs/{name}"}


def _name(ref: str) -> str:
    return ref.rpartition("/")[2]


def _is_told(value: Any) -> bool:
    return value is not None and not isinstance(value, (Mapping, list, tuple))
