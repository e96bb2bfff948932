"""The choice by `kind`: a field of a case whose table is of one of the kinds that the registry knows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler, SerializationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from ngcell.scene.registry import group
from ngcell.scene.section import validated

#: Sorts of mistakes that `ngcell.scene.complaint` puts into words.
KIND_MISSING, KIND_UNKNOWN, NO_TABLE = "kind_missing", "kind_unknown", "no_table"
#: Key of the JSON schema that says which kind a table without the key `kind` is.
DEFAULT_KIND = "x-default-kind"


@dataclass(frozen=True)
class OneOf:
    """Annotation of a field: a table whose key `kind` names a kind of a group, or, from Python, such an object.

    The kinds are looked up when a case is validated, so that one that a script registers later counts as well.

    Parameters
    ----------
    group : str
        Name of the group in `ngcell.scene.registry`.
    """

    group: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        written = core_schema.plain_serializer_function_ser_schema(_written, info_arg=True)
        return core_schema.no_info_plain_validator_function(self._validated, serialization=written)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        known = group(self.group)
        choices = {kind: _core_schema(known.section(kind)) for kind in known.names}
        node = handler(core_schema.tagged_union_schema(choices, discriminator="kind"))
        return node if known.default is None else {**node, DEFAULT_KIND: known.default}

    def _validated(self, value: Any) -> Any:
        known = group(self.group)
        if not isinstance(value, dict):
            if known.holds(value):
                return value
            raise PydanticCustomError(NO_TABLE, "allowed: {allowed}", {"allowed": known.allowed})
        kind = value.get("kind", known.default)
        if kind is None:
            raise PydanticCustomError(KIND_MISSING, "allowed: a kind of {group}", {"group": self.group})
        if not isinstance(kind, str) or kind not in known.names:
            allowed = ", ".join(known.names)
            raise PydanticCustomError(
                KIND_UNKNOWN, "kind is {kind}; allowed: {allowed}", {"kind": repr(kind), "allowed": allowed}
            )
        return validated(known.section(kind), value)


def _written(part: Any, info: SerializationInfo) -> Any:
    """Return the table of a section; an object that no case file can say appears by the name of its class."""
    if isinstance(part, BaseModel):
        return part.model_dump(mode=info.mode, exclude_none=info.exclude_none, exclude_defaults=info.exclude_defaults)
    return part if info.mode == "python" else {"kind": f"{type(part).__module__}:{type(part).__qualname__}"}


def _core_schema(section: type[BaseModel]) -> CoreSchema:
    section.model_rebuild()
    return section.__pydantic_core_schema__
