"""The mesh of many separate bodies: what every later room is told about the geometry.

Bodies share no node, not even where their walls coincide. Boundary edges are of three sorts: *walls*, which may
touch another body, *supports*, whose displacement is prescribed, and the rest, for instance a lumen. A support
may be a wall as well.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.rounded import Rounded

#: Material region of what fills lumens.
FILLING = "filling"
#: Boundary region of the lumens, where nothing tells them apart.
LUMEN = "lumen"
#: Boundary regions of the upper and the lower ends of prisms.
UPPER_END, LOWER_END = "upper-end", "lower-end"
#: Boundary regions of a tissue that its load holds or moves.
LOWER_PLATE, UPPER_PLATE, FRAME = "lower-plate", "upper-plate", "frame"
#: Those that lie along rigid side walls.
LEFT_SIDE, RIGHT_SIDE = "left-side", "right-side"
#: Name and boundary region of a rigid body that is pressed into a tissue.
INDENTER = "indenter"
#: Boundary region of the ends that face another layer of prisms.
BETWEEN = "between"


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """Separate bodies in one NGSolve mesh.

    Attributes
    ----------
    mesh : ngsolve.Mesh
        All bodies; no two share a vertex.
    body_of_element : array of int, shape (elements,)
        Body that each volume element belongs to.
    body_names : tuple of str
        Names of the bodies, by number.
    wall_names : str
        Regular expression of the boundary regions that may touch another body.
    length : float
        The length that sets the scale of a body [length]: a cell's side.
    thickness : float
        The smallest thickness of a body [length]: a cell's wall.
    thickness_of_body : array of float, shape (bodies,), optional
        Thickness of each body [length], against which its overlaps are judged; by default all have the smallest.
    is_filling : array of bool, shape (elements,), optional
        Which elements fill a lumen, bonded to their wall; they form the material region `FILLING`. By default none do.
    is_end_wall : array of bool, shape (elements,), optional
        Which elements close lumens of prisms; by default none do.
    is_swept : bool
        Whether bodies are planar rings of quadrilaterals, swept along their outlines: those around lumens have their
        first two nodes along the outer side of their layer, and the fourth behind the first on its inner side.
    rigid_count : int
        Number of rigid bodies, which are no cells: the last ones.
    rounded : Rounded, optional
        Elements that are to follow arcs, which displacements curve by their own order; by default none do.
    extent : array of float, shape (2, dimension)
        Smallest and largest coordinates [length].
    """

    mesh: ngsolve.Mesh
    body_of_element: NDArray[np.int64]
    body_names: tuple[str, ...]
    wall_names: str
    length: float
    thickness: float
    is_filling: NDArray[np.bool_] | None = None
    is_end_wall: NDArray[np.bool_] | None = None
    is_swept: bool = False
    thickness_of_body: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    rigid_count: int = 0
    rounded: Rounded | None = None
    extent: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        points = np.array([vertex.point for vertex in self.mesh.vertices])
        object.__setattr__(self, "extent", np.array([points.min(0), points.max(0)]))
        if not len(self.thickness_of_body):
            object.__setattr__(self, "thickness_of_body", np.full(self.body_count, self.thickness))

    @property
    def body_count(self) -> int:
        """Number of bodies."""
        return len(self.body_names)

    @property
    def cell_count(self) -> int:
        """Number of bodies that are not rigid."""
        return self.body_count - self.rigid_count

    @property
    def dimension(self) -> int:
        """Space dimension of the mesh."""
        return int(self.mesh.dim)
