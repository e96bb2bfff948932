"""A scene on one mesh, and a step on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar, cast

from ngcell.build.options import Options
from ngcell.clock import Clock
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Array
from ngcell.problem.problem import Problem
from ngcell.problem.state import State
from ngcell.results.equilibrium import Setup, numbers_of
from ngcell.results.error import Errors, Numbers
from ngcell.solve.minimise import Minimiser
from ngcell.solve.step import Accepted
from ngcell.solve.strategies.strategy import Problems


class Meshed(Problems, Protocol):
    """A scene on one mesh: its problems, and what else steps on it need; see `ngcell.build.simulation.Simulation`."""

    clock: Clock
    options: Options
    setup: Setup
    space: DisplacementSpace
    motion: PrescribedMotion

    @property
    def shear_moduli(self) -> Array:
        """Shear modulus of each element [stress], shape (elements,)."""

    def softer_in_bulk(self, count: int) -> tuple[Minimiser, ...]:
        """Return minimisers of walls of smaller bulk moduli, with the first of the last `count` stages of contact."""

    def problem_of(self, phase: str, *, only_leads: bool = False) -> Problem:
        """Return the problem that steps of a phase solve; of released walls also the stage that leads to the last."""


Scene = TypeVar("Scene", bound=Meshed)


@dataclass(frozen=True, eq=False)
class Refined(Generic[Scene]):
    """A step on one mesh.

    Attributes
    ----------
    level : int
        Number of the mesh, 0 for that of the load path.
    simulation : Simulation
        The scene on this mesh.
    problem : Problem
        What it solves.
    accepted : Accepted
        The step, with the effort of all meshes.
    errors : Errors
        Its estimated errors.
    is_judged : bool
        Whether they are held to what is asked for: not where none can be estimated, nor of tied states, which walls are
        released from.
    only_leads : bool
        Whether its contact only leads to the one that is meant.
    began : array of float, shape (unknowns,), optional
        The displacement of the mesh before, which it began with on its own [length].
    """

    level: int
    simulation: Scene
    problem: Problem
    accepted: Accepted
    errors: Errors
    is_judged: bool
    only_leads: bool = False
    began: Array | None = None


def step_numbers(one: Refined[Scene]) -> Numbers:
    """Return the numbers of a step that errors are estimated for."""
    simulation, minimum = one.simulation, one.accepted.minimum
    with simulation.clock.phase("measuring"):
        state = cast(State, minimum.state)
        return numbers_of(simulation.setup, one.problem, state, minimum.proximal, minimum.to_fall)
