"""How the load path is followed."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel

from ngcell.scene.section import SECTION, PositiveCount


class Sddp(BaseModel):
    """Successive deformation decomposition: load the tied tissue first, then release its walls.

    Parameters
    ----------
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level of the load.
    """

    model_config = SECTION

    kind: Literal["sddp"] = "sddp"
    steps: PositiveCount | None = None


class SingleStep(BaseModel):
    """Load and contact together.

    Parameters
    ----------
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level of the load.
    """

    model_config = SECTION

    kind: Literal["single-step"] = "single-step"
    steps: PositiveCount | None = None
