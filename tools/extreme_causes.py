"""Why points of `tools.extreme` that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_SOFT = "Springs are asked to be this soft: walls sink into each other by more than the certificate allows."
_CORNER = "Cells whose outer walls are held meet at acute corners; single points there sink in by over 2 % of the wall."
_BUCKLED = "The compact solid buckles between two levels, and what its work loses then is not stored."
_MIXED = (
    "Updates of mortar pressures stop helping at 1e-9 of the length: forces on the stiff block are 1e-5 of its own out "
    "of balance, where 1e-6 is asked for."
)
_EARLY = "Walls have to bear a pressure above their shear modulus before the path lets them touch: elements invert."

CAUSES: dict[str, str] = {
    "stiff neighbour: 1e+06 blocks, mortar": _MIXED,
    "stiff neighbour: 1e-06 blocks, mortar": _MIXED,
    "cell pressure: held tissue": _EARLY,
    "penalty: 1e-02": _SOFT,
    "shear: 1 frame": _CORNER,
    "shear: 2 frame": _CORNER,
    "shear: -2 frame": _CORNER,
    "compression: 0.75 frame": _CORNER,
    "compression: 0.5 frame": _CORNER,
    "compression: 0.5 plates": _BUCKLED,
}
