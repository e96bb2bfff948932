"""The surface of a mesh: edges in the plane, faces in three dimensions. Nothing else in this room asks which."""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import find_edges
from ngcell.contact.surface.facets import find_facets
from ngcell.contact.surface.find_lumens import find_lumens
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.bodies import BodyMesh


def find_surface(bodies: BodyMesh, scalar_space: ngsolve.H1, rest: NDArray[np.float64]) -> Surface:
    """Collect the walls of all bodies.

    Parameters
    ----------
    bodies : BodyMesh
        The mesh; its `wall_names` say which boundaries are walls.
    scalar_space : ngsolve.H1
        Space of one displacement component.
    rest : array of float, shape (dimension, scalar unknowns)
        Reference coordinates as unknowns of that space [length].

    Raises
    ------
    GeometryError
        If walls are of triangles and of quadrilaterals.
    """
    find = find_edges if _is_planar(bodies) else find_facets
    return find(bodies, scalar_space, rest)


def find_lumen_surface(
    bodies: BodyMesh, scalar_space: ngsolve.H1, rest: NDArray[np.float64]
) -> LumenSurface | None:
    """Collect the boundaries of empty lumens; None where there are none, and in three dimensions.

    Parameters are those of `find_surface`.
    """
    return find_lumens(bodies, scalar_space, rest) if _is_planar(bodies) else None


def _is_planar(bodies: BodyMesh) -> bool:
    return bodies.dimension == 2
