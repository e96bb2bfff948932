"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_PRESSED = (
    "Walls fill 87 % of the frame, and surfaces of lumens along outer walls shorten to 0.45; such surfaces crease at "
    "0.65 (Hong, Zhao and Suo 2009). Meshes of order 2, 3, 4 and graded 4 store 4.86, 4.39, 4.26 and 4.21, with an "
    "error of 9 % on the last, where the energy has a kink: no step leads to its last digits."
)

CAUSES: dict[str, str] = {
    "compression: 0.5 frame, both ways": _PRESSED,
}
