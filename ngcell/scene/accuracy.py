"""The accuracy that a case asks for."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.types import AllowInfNan

#: Relative error that energies, forces and gaps of held walls may have; infinite where no error is to be estimated.
Accuracy = Annotated[float, Field(gt=0), AllowInfNan(True)]
#: What is asked for where nobody says.
DEFAULT_ACCURACY = 0.01
