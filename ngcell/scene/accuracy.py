"""The accuracy that a case asks for."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.types import AllowInfNan

#: Format of a number that may be infinite, in the schema of case files.
OR_INFINITE = "or-infinite"
#: Relative error that energy, plate force and mean gap may have; infinite where no error is to be estimated.
Accuracy = Annotated[float, Field(gt=0, json_schema_extra={"format": OR_INFINITE}), AllowInfNan(True)]
#: What is asked for where nobody says.
DEFAULT_ACCURACY = 0.01
