"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_KINKS = (
    "Walls that are pressed to half of their length, corner on corner, go to and fro at kinks of the energy, or pass "
    "themselves at corners of lumens."
)
_FOLDED = (
    "Sides of lumens that close like a hinge press on themselves, and their contact has kinks: steps go to and fro "
    "there on the finer mesh, for forces of a hundred-thousandth of those in the walls."
)
_CLOSED = (
    "Walls hardly open, by 3 % of their thickness, at corners that come to rest elsewhere from mesh to mesh: the mean "
    "gap changes by a fifth."
)
_BETWEEN = (
    "On the finer mesh a penalty leads to the pressures of contact, and by it a pressure of twelve shear moduli gains "
    "more from walls that penetrate each other beside corners of three cells than that costs them."
)
_STIFF = "The error estimated is thirty times the small energy of walls that hardly change their volume; two minutes."
_TWISTED = "Between the points of contact the outlines of prisms overlap by 2.04 % of the wall, where 2 % are allowed."

CAUSES: dict[str, str] = {
    "cell pressure: held tissue 50": _BETWEEN,
    "cell pressure: held tissue 5": _STIFF,
    "compression: 0.5 frame": _KINKS,
    "compression: 0.75 frame": _CLOSED,
    "shear: 2 frame, penalty": _FOLDED,
    "shear: -2 frame, penalty": _FOLDED,
    "prisms: twist 90": _TWISTED,
}
