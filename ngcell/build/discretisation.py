"""From a scene to its mesh, its unknowns, its supports and the terms of its energy, contact and cohesion aside.

A tissue, user-defined bodies of a case and those of a script differ in this only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.geometry.bodies import LUMEN, BodyMesh
from ngcell.geometry.drawn import body_face
from ngcell.geometry.rings import along_walls
from ngcell.geometry.shapes import check_boundaries, mesh_shapes
from ngcell.geometry.tissue import tissue_mesh
from ngcell.mechanics.bulk import BodyEnergy, InclusionEnergy
from ngcell.mechanics.hyperelastic import MooneyRivlinLaw
from ngcell.mechanics.loading import end_loads, moved_region, prescribed_motion, prescribed_plate_displacement
from ngcell.mechanics.loads import BoundaryLoads
from ngcell.mechanics.lumens.pressure import cell_pressures
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.mechanics.term import Term
from ngcell.scene import (
    Body,
    BodyCase,
    BodyForce,
    BodyScene,
    Case,
    CellPressure,
    ExponentialFibres,
    Fluid,
    Inclusion,
    MooneyRivlin,
    Pressure,
    Traction,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A scene after meshing.

    Attributes
    ----------
    bodies : BodyMesh
        The mesh.
    space : DisplacementSpace
        The unknowns on it.
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

    bodies: BodyMesh
    space: DisplacementSpace
    walls: tuple[MooneyRivlinLaw, ...]
    solids: tuple[MooneyRivlinLaw, ...]
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
    if isinstance(scene, Case):
        return _tissue(scene)
    return _bodies(_user_defined(scene) if isinstance(scene, BodyCase) else scene)


def _tissue(case: Case) -> Discretisation:
    lumen = case.lumen
    pressures = cell_pressures(lumen, case.tissue) if isinstance(lumen, CellPressure) else None
    bodies = tissue_mesh(
        case.tissue,
        case.load,
        case.mesh,
        pressures.regions if pressures else None,
        filled=isinstance(lumen, Inclusion),
    )
    space = DisplacementSpace(bodies, case.mesh.order)
    motion, wall = prescribed_motion(space, case.load), _law(case.material)
    terms: list[Term] = [
        BodyEnergy(space, (wall,) * bodies.body_count, _wall_directions(bodies) if case.material.fibres else None)
    ]
    solids = [wall]
    if isinstance(lumen, Inclusion):
        solids.append(_law(lumen.material))
        terms.append(InclusionEnergy(space, solids[-1]))
    loads: list[Pressure | Traction] = [*(pressures.loads if pressures else ()), *end_loads(case.load)]
    if loads:
        first = isinstance(lumen, CellPressure) and lumen.ramp == "first"
        given = pressures.pressure if pressures else None
        terms.append(BoundaryLoads(space, loads, motion, in_full=first, cell_pressure=given))
    if isinstance(lumen, Fluid):
        terms.append(_fluids(space, lumen, wall.shear_modulus))
    return Discretisation(
        bodies=bodies,
        space=space,
        walls=(wall,) * bodies.body_count,
        solids=tuple(solids),
        motion=motion,
        moved=moved_region(case.load),
        prescribed_displacement=prescribed_plate_displacement(space, case.load),
        terms=tuple(terms),
    )


def _wall_directions(bodies: BodyMesh) -> Array:
    if bodies.dimension == 2:
        return along_walls(bodies.mesh)
    from ngcell.geometry.prisms import along_and_up

    return along_and_up(bodies)


def _fluids(space: DisplacementSpace, lumen: Fluid, modulus: float) -> Term:
    from ngcell.mechanics.fluid import LumenFluids

    return LumenFluids(space, LUMEN, modulus=modulus, fill=lumen.fill, in_full=lumen.ramp == "first")


def _user_defined(case: BodyCase) -> BodyScene:
    """Return the scene of a case, with the faces that it describes."""
    bodies = []
    for body in case.bodies:
        untouched = tuple(name for name in body.boundaries if name not in body.wall_boundaries)
        bodies.append(Body(body_face(body), body.material, body.name, untouched))
    return BodyScene(
        tuple(bodies),
        tuple(support.resolved for support in case.supports),
        size=case.mesh.size,
        order=case.mesh.order,
        levels=case.levels,
        steps=case.steps,
        contact=case.contact,
        loads=tuple(load.resolved for load in case.loads),
        refinements=case.mesh.refine,
        cohesion=case.cohesion,
    )


def _bodies(scene: BodyScene) -> Discretisation:
    bodies = _mesh(scene)
    space = DisplacementSpace(bodies, scene.order)
    given = [support.of_bodies(space.dimension) for support in scene.supports]
    supports = [
        Support(support.boundary, np.array(support.gradient), np.array(support.translation), support.components)
        for support in given
    ]
    moving = [support for support in given if support.moves]
    motion, laws = PrescribedMotion(space, supports), tuple(_law(body.material) for body in scene.bodies)
    terms: list[Term] = [BodyEnergy(space, laws, _fibre_directions(scene, bodies))]
    if scene.loads:
        terms.append(BoundaryLoads(space, scene.loads, motion))
    return Discretisation(
        bodies=bodies,
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
        order=scene.order,
        untouched=untouched,
        refinements=scene.refinements,
    )
    check_boundaries(bodies, untouched, wanted_by="untouched edge")
    check_boundaries(bodies, [support.boundary for support in scene.supports])
    loaded = [load.boundary for load in scene.loads if not isinstance(load, BodyForce)]
    check_boundaries(bodies, loaded, wanted_by="load")
    return bodies


def _law(material: MooneyRivlin) -> MooneyRivlinLaw:
    fibres = material.fibres
    if fibres is None:
        return MooneyRivlinLaw(material.c1, material.c2, material.bulk_modulus)
    from ngcell.mechanics.fibres import FibreLaw

    exponent = fibres.exponent if isinstance(fibres, ExponentialFibres) else 0.0
    law = FibreLaw(fibres.stiffness, exponent, tuple(np.radians(fibres.angles).tolist()))
    return MooneyRivlinLaw(material.c1, material.c2, material.bulk_modulus, law)


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
