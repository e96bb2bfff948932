"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_KINKS = (
    "Walls that are pressed to half of their length, corner on corner, go to and fro at kinks of the energy, or pass "
    "themselves at corners of lumens."
)
_SLIPS = "Walls slip as pressures take over from the penalty, and are followed on finer meshes; it takes its time."
_CLOSED = (
    "Walls hardly open, by 3 % of their thickness, at corners that come to rest elsewhere from mesh to mesh: the mean "
    "gap changes by a fifth."
)
_ENDS = "Two walls of one width slide off each other within the last element; single points sink in by 2.1 %."
_BETWEEN = (
    "Beside corners of three cells, between the points that contact is asked at, a pressure of twelve shear moduli "
    "gains more from walls that penetrate each other than that costs them; a first proximal term a hundred times as "
    "strong does not help."
)
_GRADED = (
    "Penalty terms all over a body are as stiff as its thinnest layer of elements, here a hundredth or a thousandth of "
    "the others; they open and close without end."
)
_SNAPS = "Walls of prisms that are bent this far buckle as the proximal term falls; a snap takes many iterations."

CAUSES: dict[str, str] = {
    "cell pressure: held tissue": _BETWEEN,
    "compression: 0.5 frame": _KINKS,
    "compression: 0.75 frame": _CLOSED,
    "shear: 2 frame": _SLIPS,
    "mesh: 0.02 on 0.5": _ENDS,
    "mesh: graded to 0.001": _GRADED,
    "prisms: bend 90": _SNAPS,
}
