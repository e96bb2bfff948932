"""Numbers that a case is held to."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from ngcell.scene.section import SECTION, PositiveNumber

#: The measured columns of `history.csv`; counts of iterations and times are no property of a scene.
Quantity = Literal[
    "plate_displacement",
    "largest_gap",
    "mean_gap",
    "smallest_gap",
    "parted_pairs",
    "opened_share",
    "plate_force_x",
    "plate_force_y",
    "contact_force",
    "energy",
]


class Expected(BaseModel):
    """One expected number, its tolerance and where it comes from.

    Parameters
    ----------
    level : float
        Load factor at which it holds, one of the levels of the load, in (0, 1].
    quantity : str
        Column of `history.csv`.
    value : float
        The expected number, in the units of the case.
    tolerance : float
        Largest relative deviation, > 0.
    origin : str
        Where the number comes from, not empty.
    """

    model_config = SECTION

    level: Annotated[float, Field(gt=0, le=1)]
    quantity: Quantity
    value: float
    tolerance: PositiveNumber
    origin: Annotated[str, Field(min_length=1)]
