"""A point of the map: one scene far outside comfort, and what is known of its answer."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial

from tools.extreme.scenes import Case


@dataclass(frozen=True)
class Point:
    """One scene.

    Attributes
    ----------
    group : str
        What is extreme.
    setting : str
        How much, and by which method.
    build : partial
        Makes the case, as in a TOML file; exact answers take a second.
    has_solution : bool
        Whether an equilibrium exists at the last level, by an argument that is not the solver's.
    same_as : str
        Setting of the group whose answer must be the same, without units; empty where there is none.
    units : tuple of float
        Units of length and stress, as multiples of those of the plain scene.
    is_quick : bool
        Whether it is one of those that are tried often.
    perturbed_from : str
        Label of the point that this one is a perturbation of; empty if it is none.
    tolerance : float
        Multiple of the decrement at which equilibria end.
    """

    group: str
    setting: str
    build: partial[Case]
    has_solution: bool = True
    same_as: str = ""
    units: tuple[float, float] = field(default=(1.0, 1.0))
    is_quick: bool = False
    perturbed_from: str = ""
    tolerance: float = 1.0

    @cached_property
    def case(self) -> Case:
        """The case, as in a TOML file."""
        return self.build()

    @property
    def label(self) -> str:
        """The point's key."""
        return f"{self.group}: {self.setting}"
