"""Where the lumens of empty cells are: closed loops of boundary edges around holes, whose edges are no walls."""

from __future__ import annotations

from dataclasses import fields, replace

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface, find_edges
from ngcell.contact.surface.loops import anticlockwise, closed_loops, signed_area
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.geometry.bodies import BodyMesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def find_lumens(bodies: BodyMesh, scalar_space: ngsolve.H1, rest: Array) -> LumenSurface | None:
    """Collect the boundaries of empty lumens in the plane; None where there are none.

    Parameters are those of `ngcell.contact.surface.find.find_surface`.
    """
    mesh = bodies.mesh
    is_wall = mesh.Boundaries(bodies.wall_names).Mask()
    inner = {element.mat for element in mesh.Elements(ngsolve.BND) if len(mesh[element.edges[0]].elements) > 1}
    names = {name for number, name in enumerate(mesh.GetBoundaries()) if not is_wall[number]} - inner
    if not names:
        return None
    found = find_edges(replace(bodies, wall_names="|".join(sorted(names))), scalar_space, rest)
    corners = anticlockwise(found.side, found.rest)[:, 0]
    cells = bodies.body_count - bodies.rigid_count  # what is rigid does not close
    loops = [loop for loop in closed_loops(found) if signed_area(corners[loop]) < 0 and found.body[loop[0]] < cells]
    return _surface(found, loops) if loops else None


def _surface(found: EdgeSurface, loops: list[Index]) -> LumenSurface:
    chosen = np.concatenate(loops)
    body_of_loop = found.body[[loop[0] for loop in loops]]
    per_edge = ("dofs", "nodal", "side", "weights", "depth", "rest")
    values = {each.name: getattr(found, each.name) for each in fields(found)}
    values |= {name: values[name][chosen] for name in per_edge}
    values["body"] = np.repeat(np.arange(len(loops)), [len(loop) for loop in loops])
    values["thickness"] = found.thickness[body_of_loop]
    return LumenSurface(**values, body_of_loop=body_of_loop)
