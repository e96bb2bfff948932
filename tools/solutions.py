"""A scene, solved, and what can be asked of its last step beyond the records: forces, places and pressures on walls.

The one place where studies and references touch the inside of the package; all else goes through `ngcell.simulate`,
`ngcell.record`, the command line and result folders.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import ngsolve
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ngcell.build.discretisation import discretise
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.contact.surface.surface import SurfacePoints
from ngcell.problem.reports import contact_pressures
from ngcell.results.quantities import View

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WallPressures:
    """Pressures at points of a wall in the plane.

    Attributes
    ----------
    place, place_deformed : array of float, shape (points, 2)
        Where the points are, at rest and deformed [length].
    nominal : array of float, shape (points,)
        Contact pressure per reference length [stress].
    length, length_deformed : array of float, shape (points,)
        Length that each point stands for [length].
    edge : array of int, shape (points,)
        Wall edge of each point.
    """

    place: Array
    place_deformed: Array
    nominal: Array
    length: Array
    length_deformed: Array
    edge: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class WallSamples:
    """Contact forces at the quadrature points of a body's walls.

    Attributes
    ----------
    place : array of float, shape (points, dimension)
        Where the points are at rest [length].
    force : array of float, shape (points,)
        Normal force that each stands for [stress * length] in the plane, [stress * length^2] in three dimensions.
    """

    place: Array
    force: Array


class Solution:
    """A scene that is solved while one iterates over `follow`.

    Parameters
    ----------
    scene : Case, BodyCase or BodyScene
        What is simulated.
    """

    def __init__(self, scene: Any) -> None:
        ngsolve.SetNumThreads(1)
        self._simulation = Simulation(scene)
        self.steps: list[Step] = []

    def follow(self) -> Iterator[Step]:
        """Yield the accepted steps; what is asked in between is answered for the step that came last."""
        with threadpool_limits(1, user_api="blas"):
            for step in self._simulation.accepted_steps():
                self.steps.append(step)
                yield step

    @property
    def last(self) -> Step:
        """The step that came last."""
        return self.steps[-1]

    @property
    def certified(self) -> bool:
        """Whether every step so far passed every check."""
        return all(step.record.certified for step in self.steps)

    @property
    def iterations(self) -> int:
        """Newton iterations so far."""
        return sum(step.record.iterations for step in self.steps)

    @property
    def factorisations(self) -> int:
        """Factorisations so far."""
        return sum(step.record.factorisations for step in self.steps)

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns."""
        return int(self._simulation.space.unknowns)

    @property
    def seconds(self) -> dict[str, float]:
        """Processor seconds by phase."""
        return self._simulation.clock.seconds

    @property
    def mesh(self) -> ngsolve.Mesh:
        """The mesh at rest."""
        return self._simulation.bodies.mesh

    @property
    def displacement(self) -> ngsolve.GridFunction:
        """The displacement field [length]."""
        return self._simulation.space.function(self.last.displacement)

    def resultant(self, boundary: str) -> Array:
        """Return the force of the supports of a boundary on the bodies [stress * length]."""
        return self._simulation.motion.resultant(self.last.measurement.reaction, boundary)

    def places(self, boundary: str) -> Array:
        """Return deformed places of the vertices of a boundary in the plane, shape (vertices, 2) [length]."""
        space = self._simulation.space
        at, unknowns = space.rest + self.last.displacement.reshape(2, -1), space.region_unknowns(boundary)
        return at[:, unknowns[space.one[unknowns] > 0]].T

    def wall_pressures(self, boundary: str) -> WallPressures:
        """Return the pressures along a wall in the plane."""
        simulation, last = self._simulation, self.last
        state = simulation.problem.at(last.displacement)
        view = View(simulation.problem, state, simulation.walls, simulation.motion, last.measurement.reaction)
        nominal, length, length_deformed = view.nominal_pressures(boundary)
        edges = view.edges(boundary)
        count = len(nominal) // len(edges)
        edge, xi = np.repeat(edges, count), np.tile((np.arange(count) + 0.5) / count, len(edges))
        place, moved = (view.walls.places(edge, xi, nodes) for nodes in (view.walls.rest, view.nodes))
        return WallPressures(place, moved, nominal, length, length_deformed, edge)

    def wall_samples(self, body: int) -> WallSamples:
        """Return the contact forces on the walls of a body."""
        walls = self._simulation.walls
        points = walls.quadrature
        mine = walls.body[points.facet] == body
        place = walls.places(points.facet, points.xi, walls.rest)
        return WallSamples(place[mine], (self._pressures(points) * points.weight)[mine])

    def pressures_between_cells(self, places: Array) -> Array:
        """Return the pressures at these places of each wall edge that faces another cell [stress]."""
        edge = np.unique(self._simulation.setup.facing.facet)
        count = len(places) * len(edge)
        return self._pressures(SurfacePoints(np.repeat(edge, len(places)), np.tile(places, len(edge)), np.zeros(count)))

    def _pressures(self, points: SurfacePoints) -> Array:
        problem = self._simulation.problem
        found = contact_pressures(problem.terms, problem.configuration(self.last.displacement), points)
        return np.zeros(len(points.facet)) if found is None else found


def solved(scene: Any) -> Solution:
    """Solve a scene to its last step."""
    solution = Solution(scene)
    for _ in solution.follow():
        pass
    return solution


def meshed(scene: Any) -> tuple[ngsolve.Mesh, float]:
    """Return the mesh of a scene that is not solved, and the plane-strain modulus of its softest body [stress]."""
    built = discretise(scene)
    return built.space.mesh, min(law.plane_strain_modulus for law in built.walls)
