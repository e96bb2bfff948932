"""Why points that have a solution are not certified, by how their labels start."""

from __future__ import annotations

_PRESSED = (
    "A tissue is pressed to a quarter of its area, which is hardly more than its walls have: sides of lumens pass "
    "through each other at corners."
)
_BUCKLES = (
    "Walls buckle along the axis, in waves that two slices do not resolve: 2, 4 and 8 slices store 0.61, 0.29 and 0.25 "
    "(at order 2), and none of them is certified. Sources of before certified a saddle."
)

CAUSES: dict[str, str] = {
    "compression: 0.5 frame, both ways": _PRESSED,
    "prisms: axis stretched by -0.3": _BUCKLES,
}
