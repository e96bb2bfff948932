"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_FOLDED = (
    "Elements at corners fold between their quadrature points on finer meshes, or on the mesh of the load path, from "
    "which finer ones then start inverted. On one mesh of order 3, without an estimate, frames sheared by 200 % are "
    "certified."
)
_APART = "Where cells slide to depends on the mesh: pressed to three quarters, their mean gap is known to 32 %."
_CRUSHED = "Released walls find no equilibrium; by an earlier version the tied solid buckled between two levels."
_ENDS = "Two walls of one width slide off each other within the last element; single points sink in by 2.1 %."
_BETWEEN = (
    "Beside corners of three cells, between the points that contact is asked at, a pressure above the shear modulus "
    "gains more from walls that penetrate each other than that costs them; a first proximal term a hundred times as "
    "strong does not help."
)
_GRADED = (
    "Penalty terms all over a body are as stiff as its thinnest layer of elements, here a hundredth or a thousandth of "
    "the others; they open and close without end."
)
_SNAPS = "Walls of prisms that are bent this far buckle as the proximal term falls; a snap takes many iterations."
_COARSE = "At order 2 the quadrature of prisms pressed this far misses more than 5 % of the energy."

CAUSES: dict[str, str] = {
    "cell pressure: held tissue": _BETWEEN,
    "compression: 0.5 plates, penalty": _CRUSHED,
    "compression: 0.5 plates, mortar": _APART,
    "compression: 0.5 frame": _FOLDED,
    "compression: 0.75 frame, both ways": _FOLDED,
    "compression: 0.75 plates": _APART,
    "shear: 2 frame": _FOLDED,
    "shear: -2 frame": _FOLDED,
    "mesh: 0.02 on 0.5": _ENDS,
    "mesh: graded to 0.01": _GRADED,
    "mesh: graded to 0.001": _GRADED,
    "prisms: bend 90": _SNAPS,
    "prisms: axis stretched by -0.3": _COARSE,
}
