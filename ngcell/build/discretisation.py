"""What a scene asks for, after meshing; a tissue, user-defined bodies and own bodies from Python differ in this only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.geometry.bodies import LUMEN, BodyMesh
from ngcell.geometry.rings import along_walls
from ngcell.geometry.shapes import check_boundaries, mesh_shapes
from ngcell.mechanics.filling import cell_pressures
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.loading import end_loads, moved_region, prescribed_plate_displacement, prescribed_motion
from ngcell.mechanics.loads import BoundaryLoads
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene import (
    Body,
    BodyCase,
    BodyForce,
    BodyScene,
    Case,
    CellPressure,
    Fluid,
    Inclusion,
    Sddp,
)

if TYPE_CHECKING:
    from ngcell.mechanics.fluid import LumenFluids


@dataclass(frozen=True, eq=False)
class Discretisation:
    """What a scene asks for, after meshing.

    Attributes
    ----------
    bodies : BodyMesh
        The mesh.
    space : DisplacementSpace
        The unknowns on it.
    laws : tuple of HyperelasticLaw
        Law of each body.
    motion : PrescribedMotion
        The supports.
    moved : str
        Region whose force and displacement are reported; a regular expression.
    prescribed displacement : array of float, shape (dimension,)
        Displacement of that region at load factor 1 [length].
    compact_first : bool
        Whether the bodies are loaded as one tied solid before they are released.
    loads : BoundaryLoads, optional
        What pushes and pulls besides the supports.
    filling : HyperelasticLaw, optional
        Law of what fills the lumens.
    fluid : LumenFluids, optional
        Fluids in the lumens.
    fibre_direction : array of float, shape (elements, 2), in three dimensions (elements, 6), optional
        Direction in the plane from which angles of fibres are measured, and in three dimensions that towards which they are.
    cell_pressure : array of float, shape (bodies,), optional
        Pressures that cells are under at load factor 1 [stress].
    """

    bodies: BodyMesh
    space: DisplacementSpace
    laws: tuple[HyperelasticLaw, ...]
    motion: PrescribedMotion
    moved: str
    prescribed_displacement: NDArray[np.float64]
    tied_first: bool
    loads: BoundaryLoads | None = None
    filling: HyperelasticLaw | None = None
    fluid: LumenFluids | None = None
    fibre_direction: NDArray[np.float64] | None = None
    cell_pressure: NDArray[np.float64] | None = None


def draw_up(scene: Case | BodyCase | BodyScene) -> Discretisation:
    """Mesh a scene and say what moves."""
    if isinstance(scene, Case):
        return _tissue_discretisation(scene)
    return _body_discretisation(_drawn(scene) if isinstance(scene, BodyCase) else scene)


def _tissue_discretisation(case: Case) -> Discretisation:
    lumen = case.lumen
    pressures = cell_pressures(lumen, case.tissue) if isinstance(lumen, CellPressure) else None
    bodies = case.tissue.mesh(
        case.load.supported,
        case.mesh,
        pressures.regions if pressures else None,
        filled=isinstance(lumen, Inclusion),
    )
    space = DisplacementSpace(bodies, case.mesh.order)
    motion, loads = prescribed_motion(space, case.load), None
    applied = [*(pressures.loads if pressures else ()), *end_loads(case.load)]
    if applied:
        loads = BoundaryLoads(space, applied, motion, in_full=pressures is not None and lumen.ramp == "first")
    return Discretisation(
        bodies=bodies,
        space=space,
        laws=(case.material,) * bodies.body_count,
        motion=motion,
        moved=moved_region(case.load),
        prescribed_displacement=prescribed_plate_displacement(space, case.load),
        tied_first=isinstance(case.strategy, Sddp),
        loads=loads,
        filling=lumen.material if isinstance(lumen, Inclusion) else None,
        fibre_direction=_wall_directions(bodies) if case.material.fibres else None,
        cell_pressure=pressures.pressure if pressures else None,
        fluid=_fluids(space, lumen, case.material) if isinstance(lumen, Fluid) else None,
    )


def _wall_directions(bodies: BodyMesh) -> NDArray[np.float64]:
    if bodies.dimension == 2:
        return along_walls(bodies.mesh)
    from ngcell.geometry.prisms import along_and_up

    return along_and_up(bodies)


def _fluids(space: DisplacementSpace, lumen: Fluid, wall: HyperelasticLaw) -> LumenFluids:
    from ngcell.mechanics.fluid import LumenFluids

    return LumenFluids(space, LUMEN, modulus=wall.shear_modulus, fill=lumen.fill, in_full=lumen.ramp == "first")


def _drawn(case: BodyCase) -> BodyScene:
    """Return the scene of a case, with the faces that it describes."""
    bodies = []
    for body in case.bodies:
        untouched = tuple(name for name in body.boundaries if name not in body.wall_boundaries)
        bodies.append(Body(body.face, body.material, body.name, untouched))
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


def _body_discretisation(scene: BodyScene) -> Discretisation:
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
    applied = [load.boundary for load in scene.loads if not isinstance(load, BodyForce)]
    check_boundaries(bodies, applied, wanted_by="load")
    space = DisplacementSpace(bodies, scene.order)
    given = [support.of_bodies(space.dimension) for support in scene.supports]
    supports = [
        Support(support.boundary, np.array(support.gradient), np.array(support.translation), support.components)
        for support in given
    ]
    moving = [support for support in given if support.moves]
    motion = PrescribedMotion(space, supports)
    return Discretisation(
        bodies=bodies,
        space=space,
        laws=tuple(body.material for body in scene.bodies),
        motion=motion,
        moved="|".join(scene.moved_boundaries) or "none",
        prescribed_displacement=np.array(moving[0].translation if moving else (0.0,) * space.dimension),
        tied_first=False,
        loads=BoundaryLoads(space, scene.loads, motion) if scene.loads else None,
        fibre_direction=_fibre_directions(scene, bodies),
    )


def _fibre_directions(scene: BodyScene, bodies: BodyMesh) -> NDArray[np.float64] | None:
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
            directions[number] = fibres.direction / np.linalg.norm(fibres.direction)
    return directions[bodies.body_of_element]
