"""Points of reference elements, mapped to all elements of a mesh."""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]

#: Elements that can be drawn, in the plane and in three dimensions; a mesh has one kind only.
_DRAWN = ({ngsolve.ET.QUAD}, {ngsolve.ET.TRIG}, {ngsolve.ET.TET}, {ngsolve.ET.HEX}, {ngsolve.ET.PRISM})


def element_type(space: DisplacementSpace) -> ngsolve.ET:
    """Return the kind of all elements.

    Raises
    ------
    GeometryError
        If the mesh has elements of several kinds, or pyramids.
    """
    elements = space.mesh.Elements(ngsolve.VOL)
    kinds = {element.type for element in elements}
    if kinds not in _DRAWN:
        names = ", ".join(sorted(kind.name for kind in kinds)) or "no elements"
        possible = " or ".join(f"only {kind.name}" for one in _DRAWN for kind in one)
        raise GeometryError(f"the mesh holds {names}; {possible} is possible: mesh all bodies alike")
    return kinds.pop()


def map_points(space: DisplacementSpace, kind: ngsolve.ET, points: Array) -> NDArray[np.void]:
    """Return where reference points lie in all elements, element by element; `nr` is the element's number."""
    rule = ngsolve.IntegrationRule(points=[tuple(point) for point in points], weights=[0.0] * len(points))
    return np.asarray(space.mesh.MapToAllElements({kind: rule}, ngsolve.VOL))
