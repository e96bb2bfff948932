"""What holds walls together that touch at rest. Without this table nothing does, and nothing is built for it."""

from __future__ import annotations

from pydantic import BaseModel
from pydantic_core import PydanticCustomError

from ngcell.scene.contact import Contact, Penalty
from ngcell.scene.lumen import Fluid
from ngcell.scene.section import SECTION, PositiveNumber


class Cohesion(BaseModel):
    """Bonds between all walls that coincide at rest; contact in compression stays as it is.

    The traction grows to `strength`, at the opening ``energy / (e * strength)``, and falls off exponentially behind it.

    Parameters
    ----------
    strength : float
        Largest traction between two walls, a stress, > 0; sliding and parting count alike.
    energy : float
        Energy that separates a unit of wall length at rest, of prisms of wall area, stress times length, > 0.
    """

    model_config = SECTION

    strength: PositiveNumber
    energy: PositiveNumber


def check_company(
    cohesion: Cohesion | None, contact: Contact | None, lumen: BaseModel | None = None
) -> Cohesion | None:
    """Return `cohesion` if it can go with this contact and this lumen, each None where it is not known.

    Raises
    ------
    PydanticCustomError
        If not: mortar and fluid look for multipliers at each step, and steps in which walls snap would take hours.
    """
    if cohesion is not None and contact is not None and not isinstance(contact, Penalty):
        raise PydanticCustomError(
            "limit", 'does not go with contact.kind = "mortar"; allowed: contact.kind = "penalty"', {}
        )
    if cohesion is not None and isinstance(lumen, Fluid):
        raise PydanticCustomError("limit", 'does not go with lumen.kind = "fluid"; allowed: another lumen, or none', {})
    return cohesion
