"""Numbers that user-defined bodies are held to, measured on an accepted step.

A closed list: each quantity is one function here and one name in `ngcell.scene.expected`. Forces come from resultants,
pressures from walls, each pressure for the deformed length. What is measured along a wall is measured along the first
boundary of a pair. A scene that is cut along a plane of symmetry gives the numbers of the part that is there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.search import nearest_on_body
from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface, SurfacePoints
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.problem.problem import Problem
from ngcell.problem.reports import contact_pressures, interaction
from ngcell.problem.state import State

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Points along each edge at which pressures are read.
_PER_EDGE = 20
#: Share of the peak from which on a pressure counts as contact; Hertz's distribution has it 5e-5 before its end.
_PRESSED = 1e-2


@dataclass(frozen=True, eq=False)
class View:
    """An accepted step, as the quantities see it.

    Attributes
    ----------
    problem : Problem
        What was solved: released.
    state : State
        The accepted state.
    walls : Surface
        All walls.
    motion : PrescribedMotion
        The supports.
    reaction : array of float, shape (unknowns,)
        Nodal forces of the supports on the bodies [stress * length].
    """

    problem: Problem
    state: State
    walls: Surface
    motion: PrescribedMotion
    reaction: Array

    @property
    def positions(self) -> Array:
        """Deformed positions as unknowns, shape (dimension, size) [length]."""
        return self.state.positions

    @cached_property
    def nodes(self) -> Array:
        """Deformed positions of the walls' nodes, shape (edges, order + 1, 2) [length]."""
        return self.walls.nodes(self.positions)

    @cached_property
    def boundary_of_edge(self) -> NDArray[np.str_]:
        """Name of the boundary that each wall edge belongs to."""
        bodies = self.problem.space.bodies
        return np.array([edge.mat for edge in bodies.mesh.Boundaries(bodies.wall_names).Elements()])

    def edges(self, boundary: str) -> Index:
        """Return the wall edges of a boundary."""
        return np.flatnonzero(self.boundary_of_edge == boundary)

    def outline(self, boundary: str) -> Surface:
        """Return any boundary, wall or not, as edges."""
        space = self.problem.space
        return find_surface(replace(space.bodies, wall_names=boundary), space.scalar, space.rest)

    def nominal_pressures(self, boundary: str) -> tuple[Array, Array, Array]:
        """Return pressures at points of a wall and the length that each point stands for.

        Pressures are per reference length [stress]; lengths are those at rest and deformed [length].
        """
        edge, xi = np.repeat(self.edges(boundary), _PER_EDGE), (np.arange(_PER_EDGE) + 0.5) / _PER_EDGE
        xi = np.tile(xi, len(edge) // _PER_EDGE)
        found = contact_pressures(self.problem.terms, self.state.at, SurfacePoints(edge, xi, np.zeros(len(edge))))
        pressure = np.zeros(len(edge)) if found is None else found
        at_rest, deformed = (_speed(self.walls, nodes, edge, xi) / _PER_EDGE for nodes in (self.walls.rest, self.nodes))
        return pressure, at_rest, deformed

    def pressures(self, boundary: str) -> tuple[Array, Array]:
        """Return pressures [stress] at points of a wall and the deformed length that each stands for [length]."""
        nominal, at_rest, deformed = self.nominal_pressures(boundary)
        return nominal * at_rest / deformed, deformed


def measured(view: View, quantity: str, boundaries: Sequence[str]) -> float:
    """Return a quantity on a boundary or between two."""
    return QUANTITIES[quantity](view, *boundaries)


def mean_radius(view: View, boundary: str) -> float:
    """Mean distance of a deformed boundary from the centre of the circle that it is at rest [length]."""
    outline = view.outline(boundary)
    rest = outline.rest.reshape(-1, 2)
    equations = np.column_stack([2 * rest, np.ones(len(rest))])
    centre = np.linalg.lstsq(equations, (rest**2).sum(1))[0][:2]
    nodes = outline.nodes(view.positions)
    distance = np.linalg.norm(outline.quadrature_values @ nodes - centre, axis=2)
    return float(np.average(distance, weights=_lengths(outline, nodes)))


def force_x(view: View, boundary: str) -> float:
    """Force of the supports on a boundary along x [stress * length]; a corner counts for both of its boundaries."""
    return float(view.motion.resultant(view.reaction, boundary)[0])


def force_y(view: View, boundary: str) -> float:
    """Force of the supports on a boundary along y [stress * length]; a corner counts for both of its boundaries."""
    return float(view.motion.resultant(view.reaction, boundary)[1])


def gap(view: View, one: str, two: str) -> float:
    """Mean distance of a wall to the nearest walls of the other body [length], open > 0."""
    edges, walls = view.edges(one), view.walls
    points = (walls.quadrature_values @ view.nodes[edges]).reshape(-1, 2)
    body = np.full(len(points), walls.body[view.edges(two)[0]])
    weights = _lengths(walls, view.nodes)[edges].ravel()
    return float(np.average(nearest_on_body(walls, view.nodes, points, body), weights=weights))


def normal_force(view: View, one: str, two: str) -> float:
    """Sum of the magnitudes of the normal forces between two walls [stress * length], >= 0."""
    acting = interaction(view.problem.terms, view.state.at)
    mine, theirs = view.boundary_of_edge[acting.facets].T
    between = ((mine == one) & (theirs == two)) | ((mine == two) & (theirs == one))
    return float(acting.normal[between].sum())


def contact_pressure(view: View, one: str, two: str) -> float:
    """Normal force between two walls over the deformed length of the first [stress], >= 0."""
    return normal_force(view, one, two) / float(_lengths(view.walls, view.nodes)[view.edges(one)].sum())


def pressure_spread(view: View, one: str, two: str) -> float:
    """Largest minus smallest pressure along a wall, over the contact pressure [1], >= 0; 0 without contact."""
    mean = contact_pressure(view, one, two)
    return float(np.ptp(view.pressures(one)[0])) / mean if mean else 0.0


def peak_pressure(view: View, one: str, two: str) -> float:
    """Largest pressure along a wall [stress], >= 0."""
    return float(view.pressures(one)[0].max())


def contact_width(view: View, one: str, two: str) -> float:
    """Deformed length of a wall under more than a hundredth of its largest pressure [length], >= 0."""
    pressure, length = view.pressures(one)
    return float(length[pressure > _PRESSED * pressure.max()].sum())


def nominal_peak_pressure(view: View, one: str, two: str) -> float:
    """Largest force per reference length along a wall [stress], >= 0: the pressure of theories of small strain."""
    return float(view.nominal_pressures(one)[0].max())


def nominal_contact_width(view: View, one: str, two: str) -> float:
    """Length at rest of a wall under more than a hundredth of its largest pressure [length], >= 0."""
    pressure, length, _ = view.nominal_pressures(one)
    return float(length[pressure > _PRESSED * pressure.max()].sum())


QUANTITIES: dict[str, Callable[..., float]] = {
    function.__name__: function
    for function in (
        mean_radius,
        force_x,
        force_y,
        gap,
        normal_force,
        contact_pressure,
        pressure_spread,
        peak_pressure,
        contact_width,
        nominal_peak_pressure,
        nominal_contact_width,
    )
}


def _lengths(walls: Surface, nodes: Array) -> Array:
    """Return the deformed length that each quadrature point stands for, shape (edges, points) [length]."""
    slopes = walls.basis.values(walls.quadrature_points, 1)
    speed, at_rest = (np.linalg.norm(slopes @ places, axis=2) for places in (nodes, walls.rest))
    return np.asarray(walls.weights * speed / at_rest)


def _speed(walls: Surface, nodes: Array, edge: Index, xi: Array) -> Array:
    """Return the length of the tangent at points of edges [length]."""
    return np.asarray(np.linalg.norm(np.einsum("pi,pid->pd", walls.basis.values(xi, 1), nodes[edge]), axis=1))
