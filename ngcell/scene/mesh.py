"""How finely the walls are resolved."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from ngcell.scene.section import SECTION, PositiveCount, PositiveNumber


class MeshChoice(BaseModel):
    """Order and size of the finite elements.

    Parameters
    ----------
    order : int
        Polynomial order of the displacement, 1 to 4. Order 1 locks in thin walls.
    size : float, optional
        Length of an element's edge along the wall, > 0; by default derived from the cell's side.
    layers : int, optional
        Elements through the wall, >= 1; by default derived from wall and size.
    """

    model_config = SECTION

    order: Annotated[int, Field(ge=1, le=4)] = 3
    size: PositiveNumber | None = None
    layers: PositiveCount | None = None
