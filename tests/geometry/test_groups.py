"""Bodies that touch nothing do not change each other's meshes, and curved elements stay on their own shapes."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.geometry.shapes import mesh_shapes


def ring(inner: float, outer: float) -> occ.Face:
    return (occ.Circle((0, 0), outer).Face() - occ.Circle((0, 0), inner).Face()).faces[0]


def square(x: float, y: float, side: float = 1.0) -> occ.Face:
    return occ.MoveTo(x, y).Rectangle(side, side).Face()


def pipe(x: float) -> occ.Solid:
    whole, bore = (occ.Cylinder((x, 0, 0), occ.Z, r=radius, h=0.5) for radius in (0.6, 0.3))
    return (whole - bore).solids[0]


def ball(x: float) -> occ.Solid:
    return occ.Sphere((x, 0, 0), 0.5).solids[0]


FAR = {2: lambda: square(40.3, 40.1), 3: lambda: occ.Box((9, 9, 9), (10, 10, 10)).solids[0]}
GROUPS = {
    "blocks that touch": lambda: [square(0, 0), square(-0.2, 1)],
    "rings that touch": lambda: [ring(0.5, 1.0), ring(1.0, 1.4)],
    "rings apart": lambda: [ring(0.5, 1.0), ring(1.1, 1.4)],
    "pipe": lambda: [pipe(0.0)],
    "pipe and ball": lambda: [pipe(0.0), ball(0.0)],
}


def points_of(bodies):
    """Return the corners of all elements but those of the far body, sorted, and integrals over boundaries, which see
    how elements are curved."""
    mesh, is_far = bodies.mesh, np.array(bodies.body_names)[bodies.body_of_element] == "far"
    elements = [element for element, far in zip(mesh.Elements(), is_far, strict=True) if not far]
    points = np.array([sorted(mesh[vertex].point for vertex in element.vertices) for element in elements])
    points = np.array(sorted(points.reshape(len(points), -1).tolist()))
    moments = [ngsolve.Integrate(ngsolve.CF((1, ngsolve.x**2, ngsolve.y**3)), mesh.Boundaries(name))
               for name in sorted(set(mesh.GetBoundaries())) if not name.startswith("far")]  # fmt: skip
    return points, np.array([list(moment) for moment in moments])


@pytest.mark.parametrize("name", GROUPS)
@pytest.mark.parametrize("place", ["first", "last"])
def test_a_body_far_away_does_not_change_the_others(name, place):
    shapes, again = GROUPS[name](), GROUPS[name]()  # Netgen leaves its triangles on solids
    names = [f"body{number}" for number in range(len(shapes))]
    far = FAR[3 if shapes[0].solids else 2]()
    all_names = ["far", *names] if place == "first" else [*names, "far"]
    alone = mesh_shapes(shapes, names, order=3, size=0.4)
    beside = mesh_shapes([far, *again] if place == "first" else [*again, far], all_names, order=3, size=0.4)
    assert beside.body_names == tuple(all_names)
    (points, moments), (others, other_moments) = points_of(alone), points_of(beside)
    np.testing.assert_array_equal(points, others)
    np.testing.assert_allclose(moments, other_moments, rtol=0, atol=1e-12)


def test_bodies_that_touch_have_elements_alike_in_size():
    """Netgen grades sizes over all that it meshes together."""
    fine, coarse = square(0, 0, 0.4), square(0, 0.4, 1.0)
    fine.maxh = 0.05
    touching, apart = (
        mesh_shapes([fine, occ.Translation((0, gap, 0))(coarse)], ["a", "b"], order=1, size=0.5) for gap in (0.0, 0.1)
    )
    of_coarse = [int((bodies.body_of_element == 1).sum()) for bodies in (touching, apart)]
    assert of_coarse[0] > 2 * of_coarse[1]
