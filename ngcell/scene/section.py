"""What every table of a case shares: its strictness and its number types."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, ConfigDict, Field, Strict

#: Frozen, without unknown keys; a number is a number (never a string or a boolean) and finite.
SECTION = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, defer_build=True)

PositiveNumber = Annotated[float, Field(gt=0)]
NonNegativeNumber = Annotated[float, Field(ge=0)]
PositiveCount = Annotated[int, Field(ge=1)]
#: A name that may become part of a region's name, where other signs would have a meaning of their own.
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]

#: A file, as its absolute path: what a case says is relative to the case file, see `ngcell.scene.inheritance`.
FilePath = Annotated[str, Field(min_length=1), AfterValidator(lambda text: str(Path(text).absolute()))]

#: Two numbers along x and y. TOML knows lists, not tuples: the outer shape is lax, the numbers stay strict.
PlanarVector = Annotated[tuple[float, float], Strict(False)]
