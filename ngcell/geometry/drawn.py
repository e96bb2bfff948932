"""Faces of the bodies that a case draws, with the names of their sides on their edges."""

from __future__ import annotations

from netgen import occ

from ngcell.scene import Block, Disc, Ring

#: Distance from a line, as a share of the body's size, at which an edge counts as lying on it.
_ON = 1e-9


def body_face(body: Ring | Disc | Block) -> occ.Face:
    """Return the face of a body; its edges are named ``<body>_<side>``."""
    if isinstance(body, Block):
        (left, bottom), (right, top) = body.low, body.high
        face = occ.MoveTo(left, bottom).Rectangle(right - left, top - bottom).Face()
        lines = {"bottom": (1, bottom), "top": (1, top), "left": (0, left), "right": (0, right)}
        return _named(face, body, lines, right - left + top - bottom)
    x, y = body.centre
    radius = body.outer if isinstance(body, Ring) else body.radius
    face = occ.Circle(body.centre, radius).Face()
    if isinstance(body, Ring):
        face -= occ.Circle(body.centre, body.inner).Face()
    if body.part != "whole":
        low = (x if "right" in body.part else x - 2 * radius, y if "upper" in body.part else y - 2 * radius)
        high = (x if "left" in body.part else x + 2 * radius, y if "lower" in body.part else y + 2 * radius)
        face *= occ.MoveTo(*low).Rectangle(high[0] - low[0], high[1] - low[1]).Face()
    lines = {"x0": (0, x), "y0": (1, y)}
    return _named(face, body, {side: lines[side] for side in body.cuts}, radius)


def _named(
    shape: occ.TopoDS_Shape, body: Ring | Disc | Block, lines: dict[str, tuple[int, float]], length: float
) -> occ.Face:
    """Return the only face of a shape with names on its edges: those on lines, and arcs."""
    face = shape.faces[0]
    for edge in face.edges:
        points = [(point.x, point.y) for point in (edge.start, edge.end, edge.center)]
        on = [
            side
            for side, (axis, place) in lines.items()
            if all(abs(point[axis] - place) < _ON * length for point in points)
        ]
        edge.name = f"{body.name}_{on[0] if on else _arc(body, points[0])}"
    if body.size is not None:
        face.maxh = body.size
    return face


def _arc(body: Ring | Disc | Block, point: tuple[float, float]) -> str:
    """Return which arc an end of it lies on."""
    if not isinstance(body, Ring):
        return "outer"
    distance = ((point[0] - body.centre[0]) ** 2 + (point[1] - body.centre[1]) ** 2) ** 0.5
    return "outer" if distance > (body.inner + body.outer) / 2 else "inner"
