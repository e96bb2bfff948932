"""Numbers that a case is held to."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Strict, model_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.section import PositiveNumber, Section

#: The measured columns of `history.csv`; counts of iterations and times are no property of a scene.
Quantity = Literal[
    "plate_displacement",
    "largest_gap",
    "mean_gap",
    "smallest_gap",
    "free_largest_gap",
    "free_mean_gap",
    "parted_pairs",
    "opened_share",
    "plate_force_x",
    "plate_force_y",
    "plate_force_z",
    "contact_force",
    "energy",
    "separation_energy",
    "bonded_share",
]

#: What is measured of bodies: on one boundary, and between two; see `ngcell.results.quantities`.
BodyQuantity = Literal[
    "mean_radius",
    "force_x",
    "force_y",
    "gap",
    "normal_force",
    "contact_pressure",
    "pressure_spread",
    "peak_pressure",
    "contact_width",
    "nominal_peak_pressure",
    "nominal_contact_width",
]
ROUND = ("mean_radius",)
SUPPORTED = ("force_x", "force_y")


class Expected(Section):
    """One expected number, its tolerance and where it comes from.

    Parameters
    ----------
    level : float
        Load factor at which it holds, one of the levels of the load, in [0, 1]; where the load path comes to it more
        than once, the last time.
    quantity : str
        Column of `history.csv`.
    value : float
        The expected number, in the units of the case.
    tolerance : float
        Largest relative deviation, > 0; where 0 is expected, the largest deviation itself.
    origin : str
        Where the number comes from, not empty.
    """

    level: Annotated[float, Field(ge=0, le=1)]
    quantity: Quantity
    value: float
    tolerance: PositiveNumber
    origin: Annotated[str, Field(min_length=1)]

    @property
    def place(self) -> str:
        """Where it is measured, in words: nothing for the whole scene."""
        return ""


class BodyExpected(Section):
    """One expected number of user-defined bodies, its tolerance and where it comes from.

    Parameters
    ----------
    quantity : str
        What is measured: on a boundary "mean_radius", "force_x" or "force_y"; between two boundaries "gap",
        "normal_force", "contact_pressure", "pressure_spread", "peak_pressure", "contact_width" and, per
        reference length, "nominal_peak_pressure", "nominal_contact_width".
    boundary : str, optional
        The boundary, for a quantity on one.
    between : tuple of str, shape (2,), optional
        The two boundaries, for a quantity between two. What is measured along a wall is measured along the first.
    level : float, optional
        Load factor at which it holds, one of the levels, in [0, 1], the last time that the load path comes to it; by
        default that of the last level.
    value : float
        The expected number, in the units of the case.
    tolerance : float
        Largest relative deviation, > 0; where 0 is expected, the largest deviation itself.
    origin : str
        Where the number comes from, not empty.
    """

    quantity: BodyQuantity
    boundary: str | None = None
    between: Annotated[tuple[str, str], Strict(False)] | None = None
    level: Annotated[float, Field(ge=0, le=1)] | None = None
    value: float
    tolerance: PositiveNumber
    origin: Annotated[str, Field(min_length=1)]

    @property
    def place(self) -> str:
        """Where it is measured, in words."""
        return " and ".join(self.boundaries)

    @property
    def boundaries(self) -> tuple[str, ...]:
        """The boundaries that it is measured on."""
        return self.between or (str(self.boundary),)

    @model_validator(mode="after")
    def _measured_somewhere(self) -> Self:
        wanted, other = ("boundary", "between") if self.quantity in (*ROUND, *SUPPORTED) else ("between", "boundary")
        if getattr(self, wanted) is None or getattr(self, other) is not None:
            raise PydanticCustomError(
                "limit",
                "is measured {where}; allowed: {wanted} and no {other} beside it",
                {
                    "where": "on one boundary" if wanted == "boundary" else "between two boundaries",
                    "wanted": wanted,
                    "other": other,
                    "place": ("quantity",),
                },
            )
        return self
