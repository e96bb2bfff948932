"""How finely the bodies are resolved."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, Strict, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.scope import only_for_prisms
from ngcell.scene.section import PlanarVector, PositiveCount, PositiveNumber, Section

#: A refinement with more elements across than this is a typing error.
MOST_ACROSS = 1000
#: The highest polynomial order.
HIGHEST_ORDER = 6
#: The order of user-defined bodies where none is given, and no error is to be estimated.
PLAIN_BODY_ORDER = 2

Order = Annotated[int, Field(ge=1, le=HIGHEST_ORDER)]


class MeshChoice(Section):
    """Order and size of the finite elements of a tissue.

    Parameters
    ----------
    order : int, optional
        Polynomial order of the displacement, 1 to 6; by default it follows from the accuracy that the case asks for, as
        the grading does. Order 1 locks in thin walls.
    size : float, optional
        Length of an element's edge along the wall, > 0; by default derived from the cell's side.
    layers : int, optional
        Elements through the wall, >= 1; by default derived from wall and size.
    slices : int, optional
        Elements along the height of prisms, >= 1; by default derived from height and size.
    grading : int, optional
        How often elements shrink towards the corners of lumens, where stresses are singular, 0 to 4; by default 0
        where an order is given.
    halvings : int, optional
        How often elements between graded ones are halved along the walls of a tissue, 0 to 4; by default 0 where
        order, size or grading is given, and otherwise as many as the accuracy takes.
    """

    order: Order | None = None
    size: PositiveNumber | None = None
    layers: PositiveCount | None = None
    slices: PositiveCount | None = None
    grading: Annotated[int, Field(ge=0, le=4)] | None = None
    halvings: Annotated[int, Field(ge=0, le=4)] | None = None

    @property
    def plain_order(self) -> int:
        """The order that is given, or else the one where no error is to be estimated."""
        return self.order or 3

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse slices of planar cells."""
        only_for_prisms(self, scene, "slices")


class Refinement(Section):
    """Smaller elements around a point, growing with the distance from there.

    Parameters
    ----------
    at : tuple of float, shape (2,)
        The point [length].
    within : float
        Radius of the refined circle [length], > 0.
    size : float
        Largest length of an element's edge in it [length], > 0 and at least `within` over 1000.
    """

    at: PlanarVector
    within: PositiveNumber
    size: PositiveNumber

    @field_validator("size")
    @classmethod
    def _few_enough(cls, size: float, info: ValidationInfo) -> float:
        least = info.data.get("within", 0.0) / MOST_ACROSS
        if size < least:
            raise PydanticCustomError(
                "limit", "allowed: a length >= within / {most} = {least}", {"most": MOST_ACROSS, "least": f"{least:g}"}
            )
        return size


class BodyMeshChoice(Section):
    """Order and size of the finite elements of user-defined bodies.

    Parameters
    ----------
    order : int, optional
        Polynomial order of displacement and geometry, 1 to 6; by default it follows from the accuracy that the case
        asks for.
    size : float, optional
        Largest length of an element's edge, > 0; by default half of each body's own thickness.
    refine : tuple of Refinement
        Where elements are smaller.
    """

    order: Order | None = None
    size: PositiveNumber | None = None
    refine: Annotated[tuple[Refinement, ...], Strict(False)] = ()

    @property
    def plain_order(self) -> int:
        """The order that is given, or else the one where no error is to be estimated."""
        return self.order or PLAIN_BODY_ORDER
