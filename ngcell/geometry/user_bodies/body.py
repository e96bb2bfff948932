"""What every body that a case file describes says, and how its sides get their names.

The sides of a body have names, ``<body>_<side>``, by which supports, loads and expected numbers mean them. A further
shape is one file beside this one, with its sides and its face, and one line in `ngcell.scene.registry`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, Self

from netgen import occ
from pydantic import Strict, model_validator

from ngcell.geometry.faces import check_area
from ngcell.scene.choice import OneOf
from ngcell.scene.scope import refuse
from ngcell.scene.section import Name, PositiveNumber, Section

Part = Literal["whole", "right", "left", "upper", "lower", "upper-right", "upper-left", "lower-right", "lower-left"]
Side = Literal["inner", "outer", "x0", "y0", "bottom", "top", "left", "right"]
Point = tuple[float, float]

#: Distance from a line, as a share of the body's size, at which an edge counts as lying on it.
_ON = 1e-9


class UserBody(Section):
    """What every user-defined body says.

    Parameters
    ----------
    name : str
        Letters, digits, ``_`` and ``-``.
    material : MooneyRivlin
        What it is made of.
    size : float, optional
        Largest length of an element's edge in it, > 0; by default that of the mesh.
    walls : tuple of str, optional
        Sides that may touch other bodies; by default all but the cuts, and but those that a support guides in a plane
        which all bodies are on one side of.
    """

    name: Name
    material: Annotated[Any, OneOf("material")]
    size: PositiveNumber | None = None
    walls: Annotated[tuple[Side, ...], Strict(False)] | None = None

    @property
    def sides(self) -> tuple[str, ...]:
        """Names of the sides, the cuts last."""
        raise NotImplementedError

    @property
    def face(self) -> occ.Face:
        """Its face, in the plane z = 0, with the names of its boundaries on its edges."""
        raise NotImplementedError

    @property
    def cuts(self) -> tuple[str, ...]:
        """Names of the sides that lie in planes of symmetry."""
        return ()

    @property
    def boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries of the mesh, in the order of the sides."""
        return tuple(f"{self.name}_{side}" for side in self.sides)

    @property
    def wall_boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries that may touch other bodies."""
        walls = self.walls if self.walls is not None else [side for side in self.sides if side not in self.cuts]
        return tuple(f"{self.name}_{side}" for side in walls)

    @property
    def round_boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries that are arcs of a circle."""
        return tuple(f"{self.name}_{side}" for side in self.sides if side in ("inner", "outer"))

    @model_validator(mode="after")
    def _walls_are_sides(self) -> Self:
        for number, side in enumerate(self.walls or ()):
            if side not in self.sides:
                refuse("is no side of it; allowed: {sides}", "walls", number, sides=", ".join(self.sides))
        return self


def cuts_of(part: Part) -> tuple[str, ...]:
    """Return the names of the sides along which a round body is cut."""
    across = ("x0",) if "right" in part or "left" in part else ()
    return (*across, "y0") if "upper" in part or "lower" in part else across


def part_of(face: occ.TopoDS_Shape, part: Part, centre: Point, radius: float) -> occ.TopoDS_Shape:
    """Return what is left of a round face."""
    if part == "whole":
        return face
    x, y = centre
    low = (x if "right" in part else x - 2 * radius, y if "upper" in part else y - 2 * radius)
    high = (x if "left" in part else x + 2 * radius, y if "lower" in part else y + 2 * radius)
    return face * occ.MoveTo(*low).Rectangle(high[0] - low[0], high[1] - low[1]).Face()


def named_face(
    shape: occ.TopoDS_Shape,
    body: UserBody,
    lines: Mapping[str, tuple[int, float]],
    length: float,
    area: float,
    arc: Callable[[Point], str] = lambda point: "outer",
) -> occ.Face:
    """Return the only face of a shape with names on its edges.

    Parameters
    ----------
    shape : netgen.occ shape
        The shape.
    body : UserBody
        Whose face it is.
    lines : dict of str to (int, float)
        Sides that are straight: the axis across each, and the coordinate along that axis [length].
    length : float
        Size of the body [length].
    area : float
        Its area [length**2].
    arc : function
        Returns the side that an end of any other edge lies on.

    Raises
    ------
    GeometryError
        If the shape is another one; see `check_area`.
    """
    check_area(f"body {body.name}", shape, area)
    face = shape.faces[0]
    for edge in face.edges:
        points = [(point.x, point.y) for point in (edge.start, edge.end, edge.center)]
        on = [
            side
            for side, (axis, place) in lines.items()
            if all(abs(point[axis] - place) < _ON * length for point in points)
        ]
        edge.name = f"{body.name}_{on[0] if on else arc(points[0])}"
    if body.size is not None:
        face.maxh = body.size
    return face
