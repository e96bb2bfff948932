"""Faces of the geometry library, which takes what is nearer than some length for the same, whatever the unit."""

from __future__ import annotations

from typing import Any

from ngcell.errors import GeometryError

#: Share of its area by which a face may be off.
_OFF = 1e-6


def check_area(name: str, shape: Any, area: float) -> None:
    """Check that a shape in the plane is one face of its area [length**2].

    Raises
    ------
    GeometryError
        If it is another shape, as of bodies that are tiny, or far from the origin beside their size.
    """
    faces = list(shape.faces)
    made = float(faces[0].mass) if faces else 0.0
    if not abs(made - area) <= _OFF * area:
        raise GeometryError(
            f"{name} is too small, or too far from the origin, for the geometry library, which takes what is nearer "
            f"than 1e-7 for the same: of its area of {area:.6g} it makes {made:.6g}; allowed: a unit of length in "
            "which bodies measure about 1, near the origin"
        )
