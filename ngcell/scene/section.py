"""What every table of a case shares: its strictness, its number types, and how it refuses values in a script."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetJsonSchemaHandler, Strict, ValidationError
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails

from ngcell.errors import CaseError
from ngcell.scene.meanings import meanings

#: Frozen, without unknown keys; a number is a number (never a string or a boolean) and finite.
SECTION = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, defer_build=True)

PositiveNumber = Annotated[float, Field(gt=0)]
NonNegativeNumber = Annotated[float, Field(ge=0)]
PositiveCount = Annotated[int, Field(ge=1)]
#: A name that may become part of a region's name, where other signs would have a meaning of their own.
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]
_OF_NAMES = "letters, digits, _ and -"

#: A file, as its absolute path: what a case says is relative to the case file, see `ngcell.scene.inheritance`.
FilePath = Annotated[str, Field(min_length=1), AfterValidator(lambda text: str(Path(text).absolute()))]

#: Two numbers along x and y. TOML knows lists, not tuples: the outer shape is lax, the numbers stay strict.
PlanarVector = Annotated[tuple[float, float], Strict(False)]

Model = TypeVar("Model", bound=BaseModel)
_LONGEST_VALUE = 60
#: How the validating library begins what it says of a value.
_BEGINS = ("Input should be ", "Value error, ", "Value should be ", "Assertion failed, ")


class Section(BaseModel):
    """A table of a case, which a script makes by keywords.

    Raises
    ------
    CaseError
        In a script: a value is not allowed; one line for each mistake. Where a case file is read, the reader tells it,
        with the line of the file.
    """

    model_config = SECTION

    def __init__(self, /, **values: Any) -> None:
        with _told_of(type(self)):
            super().__init__(**values)

    # With this mark the library does not call `__init__` for tables of files: their mistakes are told by the reader.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values, which are not checked; nothing that follows from the old ones is copied."""
        copied = super().model_copy(update=update, deep=deep)
        if update:
            for name in copied.__dict__.keys() - type(self).model_fields.keys():
                del copied.__dict__[name]
        return copied

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Return the section that a table of a script says; see `validated` for tables of files."""
        with _told_of(cls):
            return super().model_validate(obj, **options)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the schema of the table, whose entries mean what the docstrings say."""
        told, node = meanings(cls), handler(schema)
        for entry, what in handler.resolve_ref_schema(node).get("properties", {}).items():
            if entry in told:
                what["description"] = told[entry]
        return node


def validated(section: type[Model], table: Any) -> Model:
    """Return the section that a table of a file says.

    Raises
    ------
    ValidationError
        The table is wrong; the reader of the file tells it, with the line of the file.
    """
    if not issubclass(section, Section):
        return section.model_validate(table)
    found: Model = super(Section, section).model_validate(table)
    return found


@contextmanager
def _told_of(section: type[BaseModel]) -> Iterator[None]:
    """Tell mistakes in the values of a section in our words."""
    try:
        yield
    except ValidationError as error:
        lines = dict.fromkeys(_complaint(section, detail) for detail in error.errors())
        raise CaseError("\n".join(lines)) from None


def _complaint(section: type[BaseModel], detail: ErrorDetails) -> str:
    """Return what is wrong with a keyword, its value, and what is allowed."""
    place, known = ".".join(map(str, detail["loc"])), [*section.model_fields]
    if detail["type"] == "missing" and len(detail["loc"]) == 1:
        return f"{section.__name__}: {place} is missing; allowed: {_keywords(section)}"
    if detail["type"] == "extra_forbidden" and len(detail["loc"]) == 1:
        near = get_close_matches(place, known, n=1)
        meant = f"; did you mean {near[0]}?" if near else ""
        return f"{section.__name__}: {place} is unknown{meant}; allowed: {_keywords(section)}"
    words = _OF_NAMES if detail["type"] == "string_pattern_mismatch" else detail["msg"]
    for begin in _BEGINS:
        words = words.removeprefix(begin)
    if not detail["loc"]:
        return f"{section.__name__}: {words}"
    if detail["type"] == "limit" and not words.startswith("allowed: "):  # of several keys: it says what is wrong
        inner = (*detail["loc"], *detail.get("ctx", {}).get("place", ()))
        return f"{section.__name__}: {'.'.join(map(str, inner))}: {words}"
    words = words.rpartition("allowed: ")[2]
    value = repr(detail["input"])
    value = value if len(value) <= _LONGEST_VALUE else value[:_LONGEST_VALUE] + "..."
    return f"{section.__name__}: {place} is {value}; allowed: {words}"


def _keywords(section: type[BaseModel]) -> str:
    """Return the keywords of a section, those that it needs first."""
    needed = [name for name, entry in section.model_fields.items() if entry.is_required()]
    others = [name for name, entry in section.model_fields.items() if not entry.is_required() and name != "kind"]
    return ", ".join([*(f"{name} (needed)" for name in needed), *others])
