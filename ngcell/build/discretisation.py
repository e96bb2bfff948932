"""From a scene to its mesh, its unknowns, its supports and the terms of its energy, contact and cohesion aside.

A tissue, user-defined bodies of a case and those of a script differ in this only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.build.foreseen import check_bodies_fit, check_magnitudes, check_tissue_fits
from ngcell.errors import CaseError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.guided import without_guided_walls
from ngcell.geometry.prisms import along_and_up
from ngcell.geometry.sections import along_walls
from ngcell.geometry.shapes import check_boundaries, mesh_shapes
from ngcell.mechanics.applied.dead import terms_of_loads
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.loading.load import motion_of, with_bodies_of
from ngcell.mechanics.lumens.lumen import keeps_volume
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.mechanics.term import Term
from ngcell.results.certificate import LIMITS
from ngcell.scene import Body, BodyCase, BodyScene, Case

Array = NDArray[np.float64]

#: What quadrature rules may miss of the energy before finer ones follow, as a share of what passes. The energy jumps
#: then, and the account of work with it.
_OF_RULE = 0.8


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A scene after meshing.

    Attributes
    ----------
    space : DisplacementSpace
        The unknowns, on the mesh of all bodies.
    walls : tuple of HyperelasticLaw
        Law of the wall of each body.
    solids : tuple of HyperelasticLaw
        All laws, those of what fills lumens included.
    motion : PrescribedMotion
        The supports.
    moved : str
        Region whose force and displacement are reported; a regular expression.
    prescribed_displacement : array of float, shape (dimension,)
        Displacement of that region at load factor 1 [length].
    terms : tuple of Term
        What the energy consists of, besides contact and cohesion.
    """

    space: DisplacementSpace
    walls: tuple[HyperelasticLaw, ...]
    solids: tuple[HyperelasticLaw, ...]
    motion: PrescribedMotion
    moved: str
    prescribed_displacement: Array
    terms: tuple[Term, ...]


def discretise(scene: Case | BodyCase | BodyScene) -> Discretisation:
    """Mesh a scene, and say what moves and what acts.

    Raises
    ------
    CaseError
        If the scene cannot be meshed, or a load has no potential.
    """
    if not isinstance(scene, BodyScene):
        check_magnitudes(scene)
    if isinstance(scene, Case):
        return _tissue(scene)
    return _bodies(user_defined(scene) if isinstance(scene, BodyCase) else scene)


def _tissue(case: Case) -> Discretisation:
    check_tissue_fits(case)
    tissue, lumen, load, wall = case.tissue, case.lumen, case.load, case.material
    regions, solid = (None, None) if lumen is None else (lumen.regions(tissue), lumen.solid)
    bodies = with_bodies_of(load, tissue.mesh(load.supported, case.mesh, regions, filled=solid is not None))
    space = DisplacementSpace(bodies, case.mesh.plain_order)
    steady = lumen is not None and keeps_volume(lumen)
    motion, tractions = motion_of(load, space, keeps_volume=steady), load.tractions()
    directions = None if wall.fibres is None else _wall_directions(bodies)
    terms = [_stored_energy(space, (wall,) * bodies.body_count, directions, case.accuracy)]
    if lumen is not None:
        terms += lumen.terms(space, motion, tissue, wall)
    terms += terms_of_loads(space, tractions, motion)
    return Discretisation(
        space=space,
        walls=(wall,) * bodies.body_count,
        solids=(wall,) if solid is None else (wall, solid),
        motion=motion,
        moved=load.moved,
        prescribed_displacement=load.prescribed_displacement(space),
        terms=tuple(terms),
    )


def _stored_energy(
    space: DisplacementSpace, laws: Sequence[HyperelasticLaw], directions: Array | None, accuracy: float
) -> Term:
    """Return the stored energy of the bodies. Rules may miss less of it than is asked for, and than what passes."""
    may_miss = min(accuracy, LIMITS["quadrature_error"]) * _OF_RULE
    return BodyEnergy(space, laws, directions, may_miss=may_miss)


def _wall_directions(bodies: BodyMesh) -> Array:
    return along_walls(bodies.mesh) if bodies.dimension == 2 else along_and_up(bodies)


def user_defined(case: BodyCase) -> BodyScene:
    """Return the scene of a case, with the faces that it describes."""
    bodies = []
    for body in case.bodies:
        untouched = tuple(name for name in body.boundaries if name not in body.wall_boundaries)
        walls = () if body.walls is None else body.wall_boundaries
        bodies.append(Body(body.face, body.material, body.name, untouched, walls))
    scene = BodyScene(
        tuple(bodies),
        tuple(support.resolved for support in case.supports),
        size=case.mesh.size,
        levels=case.levels,
        steps=case.steps,
        contact=case.contact,
        loads=case.loads,
        refinements=case.mesh.refine,
        cohesion=case.cohesion,
        accuracy=case.accuracy,
        estimate_error=case.estimate_error,
    )
    object.__setattr__(scene, "order", case.mesh.order)  # an estimate may take one order more than a case may give
    return scene


def _bodies(scene: BodyScene) -> Discretisation:
    check_bodies_fit(scene)
    bodies = _mesh(scene)
    space = DisplacementSpace(bodies, scene.plain_order)
    given = [support.of_bodies(space.dimension) for support in scene.supports]
    supports = [
        Support(support.boundary, np.array(support.gradient), np.array(support.translation), support.components)
        for support in given
    ]
    moving = [support for support in given if support.moves]
    motion, laws = PrescribedMotion(space, supports), tuple(body.material for body in scene.bodies)
    terms = [_stored_energy(space, laws, _fibre_directions(scene, bodies), scene.accuracy)]
    terms += terms_of_loads(space, scene.loads, motion)
    return Discretisation(
        space=space,
        walls=laws,
        solids=laws,
        motion=motion,
        moved="|".join(scene.moved_boundaries) or "none",
        prescribed_displacement=np.array(moving[0].translation if moving else (0.0,) * space.dimension),
        terms=tuple(terms),
    )


def _mesh(scene: BodyScene) -> BodyMesh:
    untouched = [edge for body in scene.bodies for edge in body.untouched]
    bodies = mesh_shapes(
        [body.shape for body in scene.bodies],
        [body.name for body in scene.bodies],
        size=scene.size,
        order=scene.plain_order,
        untouched=untouched,
        refinements=scene.refinements,
    )
    check_boundaries(bodies, untouched, wanted_by="untouched edge")
    check_boundaries(bodies, [support.boundary for support in scene.supports])
    loaded = [load.boundary for load in scene.loads if load.boundary is not None]
    check_boundaries(bodies, loaded, wanted_by="load")
    supports = [support.of_bodies(bodies.dimension) for support in scene.supports]
    return without_guided_walls(bodies, supports, [edge for body in scene.bodies for edge in body.walls])


def _fibre_directions(scene: BodyScene, bodies: BodyMesh) -> Array | None:
    """Return the direction of each element of user-defined bodies; None where none has fibres."""
    given = [body.material.fibres for body in scene.bodies]
    if not any(given):
        return None
    if bodies.dimension != 2:
        raise CaseError("fibres; allowed: in faces in the plane, since their direction lies in it")
    directions = np.tile([1.0, 0.0], (len(given), 1))
    for number, (body, fibres) in enumerate(zip(scene.bodies, given, strict=True)):
        if fibres is not None and fibres.direction is None:
            raise CaseError(f"{body.name}: its fibres have no direction; allowed: a vector in the plane")
        if fibres is not None:
            direction = np.array(fibres.direction)
            directions[number] = direction / np.linalg.norm(direction)
    return directions[bodies.body_of_element]
