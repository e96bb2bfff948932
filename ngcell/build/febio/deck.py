"""What a deck says, from a case that is built: parts, node sets, surfaces, pairs, supports, pressures and steps."""

from __future__ import annotations

from dataclasses import dataclass

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.build.febio.layer import Layer, layer_of
from ngcell.build.febio.scope import check_case, check_support, check_terms
from ngcell.build.simulation import Simulation
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.geometry.bodies import LUMEN
from ngcell.geometry.sections import along_walls
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.fluid import LumenFluids
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.supports import Support
from ngcell.scene import AnyCase

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Stiffness of ties over that of contact.
TIE = 10.0


@dataclass(frozen=True, eq=False)
class Pair:
    """Two bodies that face each other.

    Attributes
    ----------
    names : tuple of str
        The bodies.
    edges : tuple of array of int
        Boundary edges of each that face the other.
    stiffness : float
        Penalty stiffness of contact [stress / length].
    """

    names: tuple[str, str]
    edges: tuple[Index, Index]
    stiffness: float


@dataclass(frozen=True, eq=False)
class Deck:
    """All that is written.

    Attributes
    ----------
    title : str
        Title of the case.
    layer : Layer
        Nodes and elements.
    parts : dict of str to (str, array of int)
        Material and elements of each part.
    materials : dict of str to MooneyRivlin
        The laws.
    outlines : dict of str to array of int
        Boundary edges of the walls of each body.
    pairs : list of Pair
        Bodies that face each other.
    supports : list of (Support, array of int)
        Supports at the last level, and their nodes; no two have a node in common.
    pressures : dict of str to (float, array of int)
        Pressure at the last level, and boundary edges, of each region.
    fluids : dict of str to (float, array of int)
        Area, and boundary edges, of each lumen that keeps it [length**2].
    directions : array of float, shape (elements, 2), or None
        Unit vector along the wall in each element, where walls have fibres.
    comes_first : bool
        Whether pressures are there before the supports move.
    is_tied_first : bool
        Whether walls are tied in a first step, and released in a second.
    """

    title: str
    layer: Layer
    parts: dict[str, tuple[str, Index]]
    materials: dict[str, MooneyRivlin]
    outlines: dict[str, Index]
    pairs: list[Pair]
    supports: list[tuple[Support, Index]]
    pressures: dict[str, tuple[float, Index]]
    fluids: dict[str, tuple[float, Index]]
    directions: Array | None
    comes_first: bool
    is_tied_first: bool


def deck_of(case: AnyCase) -> Deck:
    """Return the deck of a planar tissue.

    Raises
    ------
    CaseError
        If FEBio, or this export, cannot say what the case says; the message names it.
    """
    tissue = check_case(case)
    built = Simulation(tissue)
    discretisation = built.discretisation
    check_terms(discretisation.terms)
    layer = layer_of(built.bodies, built.space.order)
    regions = np.array([edge.mat for edge in built.bodies.mesh.Elements(ngsolve.BND)])
    filling = {} if len(discretisation.solids) == 1 else {"filling": discretisation.solids[1]}
    factor = float(tissue.level_factors[-1])
    loads = [term for term in discretisation.terms if isinstance(term, AppliedLoads)]
    comes_first = any(load.in_full for load in loads)
    return Deck(
        title=tissue.title,
        layer=layer,
        parts=_parts(built, layer),
        materials={"wall": discretisation.walls[0], **filling},  # type: ignore[dict-item]
        outlines={
            name: _wall_edges(built)[built.walls.body == body] for body, name in enumerate(built.bodies.body_names)
        },
        pairs=_pairs(built),
        supports=_supports(built, layer, factor),
        pressures={
            name: (value * (1.0 if comes_first else factor), np.flatnonzero(regions == name))
            for load in loads
            for name, value in load.pressures.items()
        },
        fluids=_fluids(built, regions),
        directions=along_walls(built.bodies.mesh)[layer.parent] if discretisation.walls[0].fibres else None,
        comes_first=comes_first,
        is_tied_first=getattr(tissue.strategy, "kind", "") == "sddp",
    )


def _fluids(built: Simulation, regions: NDArray[np.str_]) -> dict[str, tuple[float, Index]]:
    """Return area and boundary edges of each lumen that is full of a fluid."""
    bodies, found = built.bodies, {}
    fluids = [term for term in built.discretisation.terms if isinstance(term, LumenFluids)]
    if not fluids:
        return {}
    elements = [bodies.mesh[edge.edges[0]].elements[0].nr for edge in bodies.mesh.Elements(ngsolve.BND)]
    owner = bodies.body_of_element[elements]
    for fluid in fluids:
        for body, area in zip(fluid.body, fluid.area, strict=True):
            edges = np.flatnonzero((regions == LUMEN) & (owner == body))
            found[f"{bodies.body_names[body]}-lumen"] = float(area), edges
    return found


def _wall_edges(built: Simulation) -> Index:
    """Return the boundary edge of each wall."""
    walls = built.bodies.mesh.Boundaries(built.bodies.wall_names)
    return np.array([element.nr for element in walls.Elements()], dtype=np.int64)


def _parts(built: Simulation, layer: Layer) -> dict[str, tuple[str, Index]]:
    bodies, parts = built.bodies, {}
    is_filling = np.zeros(len(bodies.body_of_element), dtype=bool) if bodies.is_filling is None else bodies.is_filling
    for body, name in enumerate(bodies.body_names):
        for material, mine in (("wall", ~is_filling), ("filling", is_filling)):
            chosen = (mine & (bodies.body_of_element == body))[layer.parent]
            if chosen.any():
                parts[f"{name}-{material}"] = material, np.flatnonzero(chosen)
    return parts


def _pairs(built: Simulation) -> list[Pair]:
    walls, facing, edge = built.walls, built.setup.facing, _wall_edges(built)
    moduli = np.array([law.plane_strain_modulus for law in built.discretisation.walls])
    stiffness = penalty_stiffness(walls, moduli, built.options.contact.penalty_multiple)
    touching = [(pair, np.unique(facing.facet[facing.pair == number])) for number, pair in enumerate(facing.pairs)]
    outer = np.setdiff1d(np.arange(walls.facet_count), facing.facet)
    cells = np.unique(walls.body[outer[walls.body[outer] < built.bodies.cell_count]])
    for rigid in range(built.bodies.cell_count, built.bodies.body_count):  # what is pressed in faces nothing at rest
        touching += [((cell, rigid), outer[np.isin(walls.body[outer], (cell, rigid))]) for cell in cells.tolist()]
    found = []
    for pair, facets in touching:
        one, two = (facets[walls.body[facets] == body] for body in pair)
        names = tuple(built.bodies.body_names[body] for body in pair)
        found.append(Pair((names[0], names[1]), (edge[one], edge[two]), float(stiffness[facets].min())))
    return found


def _supports(built: Simulation, layer: Layer, factor: float) -> list[tuple[Support, Index]]:
    """Return supports at a load factor with their nodes; where two meet, the later one counts."""
    mesh, taken, found = built.bodies.mesh, np.zeros(0, dtype=np.int64), []
    for support in reversed(built.motion.supports):
        check_support(support)
        edges = np.array([element.nr for element in mesh.Boundaries(support.region).Elements()], dtype=np.int64)
        nodes = np.setdiff1d(layer.on(edges), taken)
        taken = np.union1d(taken, nodes)
        moved = Support(support.region, factor * support.gradient, factor * support.translation, support.components)
        found.append((moved, nodes))
    return found[::-1]
