"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_PRESSED = (
    "Walls fill 87 % of the frame, and surfaces of lumens along outer walls shorten to 0.45; such surfaces crease at "
    "0.65 (Hong, Zhao and Suo 2009). Meshes of order 2, 3, 4 and graded 4 store 4.86, 4.39, 4.26 and 4.21, with an "
    "error of 9 % on the last, where the energy has a kink: no step leads to its last digits."
)

_BLOWN_UP = (
    "Cells are pressed against each other by fifty moduli. The last iterations go to and fro at a kink, at a decrement "
    "of 4e-15, and leave more out of balance than a certificate allows; the contact force is within 6e-4 of the exact."
)

CAUSES: dict[str, str] = {
    "compression: 0.5 frame, both ways": _PRESSED,
    "cell pressure: held tissue 50": _BLOWN_UP,
}
