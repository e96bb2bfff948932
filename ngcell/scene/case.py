"""A case: everything that a simulation is told, and nothing that it works out."""

from __future__ import annotations

from math import isclose
from typing import Annotated, Any, Self

from pydantic import Field, Strict, ValidationInfo, field_validator, model_validator

from ngcell.scene.accuracy import DEFAULT_ACCURACY, Accuracy
from ngcell.scene.choice import OneOf
from ngcell.scene.expected import Expected
from ngcell.scene.mesh import MeshChoice
from ngcell.scene.registry import default_of
from ngcell.scene.scope import in_scope, refuse
from ngcell.scene.section import Section

#: Parts of a case that the registry knows the kinds of, or, from Python, objects that offer the same.
Tissue = Annotated[Any, OneOf("tissue")]
Material = Annotated[Any, OneOf("material")]
Lumen = Annotated[Any, OneOf("lumen")]
Load = Annotated[Any, OneOf("load")]
Strategy = Annotated[Any, OneOf("strategy")]
Contact = Annotated[Any, OneOf("contact")]
Cohesion = Annotated[Any, OneOf("cohesion")]
Observables = Annotated[tuple[Annotated[Any, OneOf("observable")], ...], Strict(False)]


def _default(group: str) -> Any:
    return Field(default_factory=lambda: default_of(group))


class Case(Section):
    """One scene, how it is loaded and how it is to be solved.

    Lengths are in the unit of the cells' side, stresses in the unit of the material's constants; every
    other unit follows from these two.

    Parameters
    ----------
    title : str
        One line that says what happens.
    source : str
        Where the scene comes from.
    tissue : Tissue
        The cells.
    material : MooneyRivlin
        What their walls are made of.
    lumen : CellPressure, Inclusion or Fluid, optional
        What the cells hold; by default they are empty.
    load : Plates, Frame, Ends or Indenter
        What moves them.
    strategy : Sddp, SingleStep or LoadStepping
        How the load path is followed.
    contact : Penalty, Mortar or NgsolveContact
        What walls do to each other.
    cohesion : Cohesion, optional
        What holds walls together; by default nothing does.
    accuracy : float
        Relative error that energy, plate force and mean gap may have, > 0; the mesh follows from it, and a
        result whose estimated error is larger is not certified. Infinite where nothing is to follow from it.
    estimate_error : bool
        Whether errors are estimated, on finer meshes. Where they are not, results are of the mesh of the load path, and
        contact and the end of the continuation follow from `accuracy` alone.
    mesh : MeshChoice
        How finely the walls are resolved; what is said here is kept.
    observables : tuple of Rotation or SelfContactForce
        What is measured besides what every run measures; each becomes a column and a field.
    expected : tuple of Expected
        Numbers that the case is held to.
    """

    title: str = ""
    source: str = ""
    tissue: Tissue
    material: Material
    lumen: Lumen | None = None
    load: Load
    strategy: Strategy = _default("strategy")
    contact: Contact = _default("contact")
    cohesion: Cohesion | None = None
    accuracy: Accuracy = DEFAULT_ACCURACY
    estimate_error: bool = True
    mesh: MeshChoice = MeshChoice()
    observables: Observables = ()
    expected: Annotated[tuple[Expected, ...], Strict(False)] = ()

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        factors: tuple[float, ...] = self.load.level_factors
        return factors

    @property
    def smallest_step_count(self) -> int:
        """Smallest number of load steps: what the strategy asks for, else one for each level."""
        return self.strategy.steps or len(self.level_factors)

    @field_validator("tissue", "material", "lumen", "load", "strategy", "contact", "cohesion", "mesh")
    @classmethod
    def _goes_with_the_rest(cls, part: Any, info: ValidationInfo) -> Any:
        return in_scope(part, info)

    @field_validator("expected")
    @classmethod
    def _at_reported_levels(cls, expected: tuple[Expected, ...], info: ValidationInfo) -> tuple[Expected, ...]:
        reported = info.data["load"].level_factors if "load" in info.data else ()
        for number, entry in enumerate(expected if reported else ()):
            if not any(isclose(entry.level, factor) for factor in reported):
                levels = ", ".join(f"{factor:g}" for factor in reported)
                allowed = "is not reported; allowed: a level of the load ({reported})"
                refuse(allowed, number, "level", reported=levels)
        return expected

    @model_validator(mode="after")
    def _can_be_followed(self) -> Self:
        kinds, kind = getattr(self.load, "strategies", None), getattr(self.strategy, "kind", None)
        if kinds is not None and kind is not None and kind not in kinds:
            words = "is {kind}, which cannot follow this load; allowed: {kinds}"
            refuse(words, "strategy", "kind", kind=kind, kinds=", ".join(kinds))
        return self
