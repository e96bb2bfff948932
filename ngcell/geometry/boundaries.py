"""Closed boundaries of bodies in Netgen's mesh, loops of edges and shells of faces alike: their names, and which of
them are walls."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol, TypeVar

import netgen.meshing
import ngsolve
import numpy as np
from netgen import occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.scene.entries import PLAIN_NAME

Array = NDArray[np.float64]

#: What Netgen raises where it cannot make a mesh: its own error, that of OpenCASCADE, and what Python makes of others.
NETGEN_ERRORS = (netgen.meshing.NgException, occ.OCCException, RuntimeError)


class ClosedBoundary(Protocol):
    """A loop or a shell."""

    @property
    def body(self) -> int:
        """Whose boundary it is."""

    @property
    def members(self) -> frozenset[int]:
        """Which of Netgen's edges, or faces."""

    @property
    def diagonal(self) -> float:
        """Diagonal of the bounding box [length]."""

    def encloses(self, points: Array) -> bool:
        """Return whether any point, shape (n, dimension), is inside."""


Closed = TypeVar("Closed", bound=ClosedBoundary)


def outlines(boundaries: Sequence[Closed]) -> dict[int, Closed]:
    """Return the outline of each body: its largest boundary, the first of equals."""
    found: dict[int, Closed] = {}
    for boundary in boundaries:
        if boundary.body not in found or boundary.diagonal > found[boundary.body].diagonal:
            found[boundary.body] = boundary
    return found


def name_boundaries(
    mesh: netgen.meshing.Mesh,
    boundaries: Sequence[ClosedBoundary],
    names: Sequence[str],
    centres: Array,
    body: NDArray[np.int64],
) -> set[str]:
    """Name the edges or faces that have no name, and return the names of walls.

    Parameters
    ----------
    mesh : netgen.meshing.Mesh
        The mesh.
    boundaries : sequence of ClosedBoundary
        All of them.
    names : sequence of str
        Of the bodies.
    centres : array of float, shape (elements, dimension)
        Centres of all elements [length].
    body : array of int, shape (elements,)
        Body of each element.

    Raises
    ------
    GeometryError
        If a name has characters that are not allowed.
    """
    kind_of_member = "edge" if centres.shape[1] == 2 else "face"
    outer, holes, walls = outlines(boundaries), [0] * len(names), set()
    for boundary in boundaries:
        kind, is_wall = "outline", True
        if boundary is not outer[boundary.body]:
            kind = f"hole{holes[boundary.body]}"
            is_wall = boundary.encloses(centres[body != boundary.body])
            holes[boundary.body] += 1
        for member in boundary.members:
            name = _named(mesh, member, f"{names[boundary.body]}_{kind}", kind_of_member)
            walls |= {name} if is_wall else set()
    return walls


def _named(mesh: netgen.meshing.Mesh, member: int, otherwise: str, kind: str) -> str:
    """Return the name of an edge or a face, after giving it one if it had none."""
    name = str(mesh.GetBCName(member - 1))
    if name == "default":
        mesh.SetBCName(member - 1, otherwise)
        return otherwise
    if not PLAIN_NAME.fullmatch(name):
        raise GeometryError(f"{kind} name {name!r}; allowed: letters, digits, _ and -")
    return name


def named_bodies(
    mesh: netgen.meshing.Mesh,
    boundaries: Sequence[ClosedBoundary],
    names: Sequence[str],
    body: NDArray[np.int64],
    *,
    centres: Array,
    order: int,
    thicknesses: Sequence[float],
    untouched: Collection[str],
) -> BodyMesh:
    """Return the mesh of bodies with names on their materials and boundaries, curved with an order.

    Parameters
    ----------
    mesh, boundaries, names, centres, body
        As for `name_boundaries`.
    order : int
        Order of the curved elements, >= 1.
    thicknesses : sequence of float
        Thickness of each body [length].
    untouched : collection of str
        Boundaries that are no walls, wherever they lie.
    """
    walls = name_boundaries(mesh, boundaries, names, centres, body) - set(untouched)
    for number, name in enumerate(names):
        mesh.SetMaterial(number + 1, name)
    return BodyMesh(
        mesh=ngsolve.Mesh(mesh).Curve(order),
        body_of_element=body,
        body_names=tuple(names),
        wall_names="|".join(sorted(walls)),
        length=min(boundary.diagonal for boundary in outlines(boundaries).values()) / 2,
        thickness=min(thicknesses),
        thickness_of_body=np.array(thicknesses),
    )
