"""What was built, to be drawn before it is solved: elements, walls and supports at rest."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Layout:
    """Bodies in the plane at rest.

    Attributes
    ----------
    elements : list of array of float, shape (corners, 2)
        Corners of each element [length].
    body : array of int, shape (elements,)
        Body that each belongs to.
    is_filling : array of bool, shape (elements,)
        Which elements fill a lumen.
    edges : dict of str to array of float, shape (edges, 2, 2)
        Ends of the edges of each boundary region [length].
    wall_names : tuple of str
        Regions that may touch another body.
    support_names : tuple of str
        Regions that are held or moved.
    rigid_count : int
        Number of rigid bodies, which are the last ones; each is a shell, whose elements begin with their outer edge.
    """

    elements: list[Array]
    body: NDArray[np.int64]
    is_filling: NDArray[np.bool_]
    edges: dict[str, Array]
    wall_names: tuple[str, ...]
    support_names: tuple[str, ...]
    rigid_count: int = 0


def layout_of(bodies: BodyMesh, supports: Sequence[str]) -> Layout:
    """Return the layout of bodies whose supports have these regions, regular expressions.

    Raises
    ------
    GeometryError
        If the bodies are not in the plane.
    """
    if bodies.dimension != 2:
        raise GeometryError("solids have no picture before they are solved; allowed: bodies in the plane, tissues")
    mesh = bodies.mesh
    points = np.array([vertex.point for vertex in mesh.vertices])
    edges: dict[str, list[list[int]]] = {}
    for edge in mesh.Elements(ngsolve.BND):
        edges.setdefault(edge.mat, []).append([vertex.nr for vertex in edge.vertices])
    filling = bodies.is_filling
    return Layout(
        elements=[points[[vertex.nr for vertex in element.vertices]] for element in mesh.Elements(ngsolve.VOL)],
        body=bodies.body_of_element,
        is_filling=np.zeros(mesh.ne, dtype=bool) if filling is None else filling,
        edges={name: points[ends] for name, ends in edges.items()},
        wall_names=_named(edges, [bodies.wall_names]),
        support_names=_named(edges, supports),
        rigid_count=bodies.rigid_count,
    )


def _named(regions: dict[str, list[list[int]]], patterns: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in regions if any(re.fullmatch(pattern, name) for pattern in patterns))
