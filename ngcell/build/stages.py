"""The meshes of a scene: from the one on which the load path is followed to finer ones, on which its steps end.

Which equilibrium walls find is settled on a coarse mesh, where most of the iterations are; the state then goes on to
finer ones, each of which knows the functions of the one before. The error of what is reported follows from what the
last refinement has changed; see `ngcell.results.error`. Towards the corners of lumens, where stresses are singular,
elements are graded as their order rises, which is what lets errors fall exponentially in the unknowns (Schwab, p- and
hp-Finite Element Methods, 1998). A mesh that a case gives is kept: one order more tells its error, and nothing else.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from math import isinf

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.rings import GRADE
from ngcell.geometry.tissues.protocol import TissueGeometry
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.term import Array
from ngcell.results.parts_of_error import Refining
from ngcell.results.places import element_type, map_points
from ngcell.scene import AnyCase, BodyScene, Case
from ngcell.scene.mesh import HIGHEST_ORDER

#: Order and grading of the meshes of a tissue, one after the other: what a grade leaves of an error is known only from
#: the step in order before it. The finest is left out where a low accuracy is asked for.
_TISSUE, _FINE = ((2, 1), (3, 1), (4, 1), (4, 2), (5, 2), (6, 3)), 0.02
#: How often elements along walls of hollow cells are halved, on every mesh, for a higher accuracy. In 35 cells long
#: elements between corners have two fifths of what order 4 has beyond order 3, and these a tenth. Soft tissues slide
#: from mesh to mesh for what is missing: by 5 % of their mean gap with long ones, and by 1 to 2 % with these.
#: It is done below the first accuracy, and for few cells whose sides are equal, within a share, below the second: at
#: 0.01 these take two thirds of the time without.
_HALVED, _MAY_SLIDE, _FEW_MAY_SLIDE, _MANY, _EQUAL = 1, 0.05, 0.01, 25, 0.01
#: Lowest order of filled cells of any shape in the plane: at order 2 they are so far off that on the next mesh their
#: walls would have to be settled anew.
_FILLED = 3
#: Exponents of the displacement's growth with the distance from the end of a contact, and from a corner that is held on
#: one side (Williams, J. Appl. Mech. 19, 1952); angles in radians from which on an outline is re-entrant, and up to
#: which it has a corner.
_SMOOTH, _HELD_CORNER, _REENTRANT, _CORNER = 1.5, 0.71, np.radians(200), np.radians(150)
#: Exponent of the strongest singularity that bodies with corners have, that of cracks and of the edges of punches.
_STRONGEST = 0.5
#: Corners of the reference elements, in the order of their vertices.
_CORNERS = {
    ngsolve.ET.TRIG: np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]),
    ngsolve.ET.QUAD: np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
}


@dataclass(frozen=True, eq=False)
class Stage:
    """One mesh of a scene.

    Attributes
    ----------
    scene : Case, BodyCase or BodyScene
        The scene, with order and grading given.
    order, grading : int
        Order of its elements, and how often they are graded towards corners.
    is_reported : bool
        Whether its numbers may be reported; else they serve an estimate only.
    """

    scene: AnyCase | BodyScene
    order: int
    grading: int
    is_reported: bool = True

    @property
    def entries(self) -> dict[str, int]:
        """Order, grading and halvings, by the names of the entries of `mesh` that give them."""
        halvings = getattr(getattr(self.scene, "mesh", None), "halvings", None) or 0
        return {"order": self.order, "grading": self.grading, "halvings": halvings}

    def refining(self, before: Stage, exponent: float) -> Refining:
        """Return how it is finer than the stage before, if a singularity of this exponent rules the error.

        Energies err by h**(2 exponent) in the size of the elements at the singularity, and by p**(-4 exponent) in
        their order (Babuska and Suri, SIAM Rev. 36, 1994, doi:10.1137/1036141). What one order leaves is that power of
        p + 1/2: at a corner of 270 degrees to 3 % from order 4 on, where that of p is 4 % too small. Gaps of tissues
        follow no such law, and keep the power of p.
        """
        orders, grades = (before.order + 0.5) / (self.order + 0.5), self.grading - before.grading
        elsewhere = orders ** (4 * (_STRONGEST if exponent < 1 else exponent))
        graded = GRADE ** (2 * exponent * grades)
        of_gaps = (before.order / self.order) ** (4 * exponent) * graded
        return Refining(float(orders ** (4 * exponent) * graded), grades > 0, elsewhere, float(of_gaps))


def stages_of(scene: AnyCase | BodyScene, *, finest: bool = False) -> tuple[Stage, ...]:
    """Return the meshes of a scene, the coarsest first, with the finest of all if that is asked for."""
    mesh = scene if isinstance(scene, BodyScene) else scene.mesh
    given, grading, is_tissue = mesh.order, getattr(mesh, "grading", None), isinstance(scene, Case)
    if not_estimated(scene):
        return (_stage(scene, mesh.plain_order, grading or 0),)
    if given is not None:
        kept = _stage(scene, given, grading or 0)
        return kept, one_order_more(kept)
    if is_tissue and grading is None and _has_meshed_lumens(scene):
        # Lumens that Netgen meshes are meshed anew for each grading: none is part of another.
        lowest = _FILLED if getattr(getattr(scene, "tissue", None), "height", None) is None else 2
        chosen = [(order, 1) for order in range(lowest, HIGHEST_ORDER + 1)]
    elif isinstance(scene, Case) and grading is None:
        chosen = list(_TISSUE if finest or scene.accuracy < _FINE else _TISSUE[:-1])
        if _may_slide(scene):
            halved = scene.mesh.model_copy(update={"halvings": _HALVED})
            scene = scene.model_copy(update={"mesh": halved})
    else:
        chosen = [(order, grading or 0) for order in range(2, HIGHEST_ORDER + 1)]
    return tuple(_stage(scene, *step) for step in chosen)


def one_order_more(stage: Stage) -> Stage:
    """Return the mesh of a stage with elements of one order more, which serves an estimate only."""
    return _stage(stage.scene, stage.order + 1, stage.grading, is_reported=False)


def not_estimated(scene: AnyCase | BodyScene) -> str:
    """Return why the errors of a scene are not estimated; empty where they are."""
    if isinf(scene.accuracy):
        return "accuracy = inf"
    if not scene.estimate_error:
        return "estimate_error = false"
    return "bonds remember how they were loaded" if scene.cohesion is not None else ""


def _has_meshed_lumens(scene: AnyCase | BodyScene) -> bool:
    """Return whether elements in lumens, or of what closes them, depend on how walls are graded."""
    tissue, lumen = getattr(scene, "tissue", None), getattr(scene, "lumen", None)
    is_meshed = getattr(lumen, "solid", None) is not None or getattr(tissue, "end_wall", None) is not None
    return is_meshed and not getattr(tissue, "nests_lumens", True)


def _may_slide(case: Case) -> bool:
    """Return whether a tissue may be so soft that its cells slide from mesh to mesh beside what is asked for."""
    is_planar = getattr(case.tissue, "height", None) is None
    is_hollow = getattr(case.lumen, "solid", None) is None
    if not is_planar or not is_hollow or case.mesh.size is not None or case.mesh.halvings is not None:
        return False
    return bool(case.accuracy < (_FEW_MAY_SLIDE if _are_few_and_alike(case.tissue) else _MAY_SLIDE))


def _are_few_and_alike(tissue: TissueGeometry) -> bool:
    """Return whether few cells have sides of one length; a tissue from a script need not tell its outlines."""
    outlines = getattr(tissue, "outlines", None)
    if outlines is None or tissue.cell_count >= _MANY:
        return False
    return bool(np.ptp(outlines.lengths) < _EQUAL * outlines.lengths.max())


def _stage(scene: AnyCase | BodyScene, order: int, grading: int, *, is_reported: bool = True) -> Stage:
    meshed: AnyCase | BodyScene
    if isinstance(scene, BodyScene):
        meshed = copy(scene)
        object.__setattr__(meshed, "order", order)  # an estimate may take one order more than a scene may give
    else:
        chosen = {"order": order, "grading": grading} if isinstance(scene, Case) else {"order": order}
        meshed = scene.model_copy(update={"mesh": scene.mesh.model_copy(update=chosen)})
    return Stage(meshed, order, grading, is_reported)


def singular_exponent(space: DisplacementSpace) -> float:
    """Return the smallest exponent with which the displacement grows from a corner of a body, or the end of a contact.

    At a re-entrant corner of angle w, free on both sides, it is the root of ``sin(x w) + x sin(w) = 0`` (Williams
    1952); what fills a lumen is much softer than the wall, whose corners there count as free. In three dimensions a
    right angle is taken.
    """
    if space.dimension == 3:
        return _free_exponent(1.5 * np.pi)
    angles = _angles_of_bodies(space)
    if angles.max(initial=0.0) > _REENTRANT:
        return _free_exponent(float(angles.max()))
    return _HELD_CORNER if angles.min(initial=np.pi) < _CORNER else _SMOOTH


def _free_exponent(angle: float) -> float:
    exponent = np.linspace(0.5, 1.0, 10_001)
    return float(exponent[np.argmax(np.sin(exponent * angle) + exponent * np.sin(angle) <= 0)])


def _angles_of_bodies(space: DisplacementSpace) -> Array:
    """Return the angle between the tangents of the body at each vertex of outlines in the plane, and that of the wall
    where it meets what fills its lumen [radian]."""
    mesh, is_filling = space.bodies.mesh, space.bodies.is_filling
    kind = element_type(space)
    corners = _CORNERS[kind]
    jacobian = np.asarray(ngsolve.specialcf.JacobianMatrix(2)(map_points(space, kind, corners)))
    jacobian = jacobian.reshape(-1, len(corners), 2, 2)
    ahead, behind = (
        np.einsum("ncij,cj->nci", jacobian, np.roll(corners, by, axis=0) - corners) for by in (-1, 1)
    )
    turn = np.arctan2(ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0], (ahead * behind).sum(2))
    vertices = np.array([[vertex.nr for vertex in element.vertices] for element in mesh.Elements()])
    on_outline = np.zeros(mesh.nv, dtype=bool)
    for edge in mesh.Boundaries(".*").Elements():
        on_outline[[vertex.nr for vertex in edge.vertices]] = True
    whole = _angles_at(vertices, turn, mesh.nv)[on_outline]
    if is_filling is None or not is_filling.any():
        return whole
    is_filled = np.zeros(mesh.nv, dtype=bool)
    is_filled[vertices[is_filling]] = True
    walls = _angles_at(vertices[~is_filling], turn[~is_filling], mesh.nv)
    return np.concatenate([whole, walls[is_filled & (walls > 0)]])


def _angles_at(vertices: NDArray[np.int64], turn: Array, count: int) -> Array:
    """Return the angle of elements at each vertex [radian], from those at their corners."""
    return np.asarray(np.bincount(vertices.ravel(), np.abs(turn).ravel(), count), dtype=float)
