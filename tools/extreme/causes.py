"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_PRESSED = (
    "A tissue is pressed to a quarter of its area, which is hardly more than its walls have: sides of lumens pass "
    "through each other at corners."
)
_BETWEEN = (
    "On the finer mesh a penalty leads to the pressures of contact, and by it a pressure of twelve shear moduli gains "
    "more from walls that penetrate each other beside corners of three cells than that costs them."
)

CAUSES: dict[str, str] = {
    "cell pressure: held tissue 50": _BETWEEN,
    "compression: 0.5 frame, both ways": _PRESSED,
}
