"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_CORNER = "Cells whose outer walls are held meet at acute corners; single points there sink in by over 2 % of the wall."
_BUCKLED = "The tied solid buckles between two levels, and what its work loses then is not stored."
_BETWEEN = (
    "Beside corners of three cells, between the points that contact is asked at, a pressure above the shear modulus "
    "gains more from walls that penetrate each other than that costs them; a first proximal term a hundred times as "
    "strong does not help."
)
_GRADED = (
    "Penalty terms all over a body are as stiff as its thinnest layer of elements, here a thousandth of the others; "
    "they open and close without end."
)
_SNAPS = (
    "Walls of prisms that are bent or pressed this far buckle as the proximal term falls, and a snap takes more than "
    "the 200 iterations that a minimisation had when this map was made; with 600, bending ends at the next snap but "
    "one. With the thousand that it has since, the prisms pressed along their axis are certified."
)

CAUSES: dict[str, str] = {
    "cell pressure: held tissue": _BETWEEN,
    "compression: 0.5 frame": _CORNER,
    "compression: 0.5 plates": _BUCKLED,
    "mesh: graded to 0.001": _GRADED,
    "prisms: bend 90": _SNAPS,
    "prisms: axis stretched by -0.3": _SNAPS,
}
