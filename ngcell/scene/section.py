"""What every table of a case shares: its strictness, its number types and the choice by `kind`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, Strict
from pydantic_core import CoreSchema, core_schema

#: Frozen, without unknown keys; a number is a number (never a string or a boolean) and finite.
SECTION = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, defer_build=True)

PositiveNumber = Annotated[float, Field(gt=0)]
NonNegativeNumber = Annotated[float, Field(ge=0)]
PositiveCount = Annotated[int, Field(ge=1)]

#: Two numbers along x and y. TOML knows lists, not tuples: the outer shape is lax, the numbers stay strict.
PlanarVector = Annotated[tuple[float, float], Strict(False)]


@dataclass(frozen=True)
class ByKind:
    """Annotation of a union of section classes: the key `kind` of the table says which of them it is.

    Each class has ``kind: Literal["..."]``. Unlike pydantic's own discriminator this also holds for a
    union of one, so that the first class of a room is read and reported as every later one will be.

    Parameters
    ----------
    default : str, optional
        Kind of a table that names none; by default the table has to name one.
    """

    default: str | None = None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        classes: tuple[type[BaseModel], ...] = get_args(source) or (source,)
        choices = {cls.model_fields["kind"].default: handler.generate_schema(cls) for cls in classes}
        by_kind = core_schema.tagged_union_schema(choices, discriminator="kind")
        return core_schema.no_info_before_validator_function(self._name_kind, by_kind)

    def _name_kind(self, table: Any) -> Any:
        unnamed = isinstance(table, dict) and "kind" not in table
        return {**table, "kind": self.default} if unnamed and self.default else table
