"""A case of user-defined bodies: what they are, what holds, moves and loads them, and the numbers they are held to."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from math import isclose
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, ValidationInfo, field_validator

from ngcell.errors import CaseError
from ngcell.scene.accuracy import DEFAULT_ACCURACY, Accuracy
from ngcell.scene.bodies import BodySupport
from ngcell.scene.case import Cohesion, Contact, Observables, Strategy
from ngcell.scene.choice import OneOf
from ngcell.scene.expected import ROUND, SUPPORTED, BodyExpected
from ngcell.scene.levels import Levels, level_factors
from ngcell.scene.mesh import BodyMeshChoice
from ngcell.scene.registry import default_of
from ngcell.scene.scope import in_scope, refuse
from ngcell.scene.section import Name, PlanarVector, PositiveCount, Section


class SupportEntry(Section):
    """A boundary whose displacement is ``load_factor * (gradient @ X + translation)`` at the reference position X.

    Parameters
    ----------
    boundary : str
        Name of a boundary, ``<body>_<side>``.
    gradient : tuple of tuple of float, shape (2, 2)
        Displacement gradient at load factor 1, without unit.
    translation : tuple of float, shape (2,)
        Displacement of the origin at load factor 1 [length].
    components : {"xy", "x", "y"}
        Which components are prescribed; the others are free. Where supports meet, the later one counts.
    """

    boundary: Name
    gradient: Annotated[tuple[PlanarVector, PlanarVector], Strict(False)] = ((0.0, 0.0), (0.0, 0.0))
    translation: PlanarVector = (0.0, 0.0)
    components: Literal["xy", "x", "y"] = "xy"

    @property
    def resolved(self) -> BodySupport:
        """The support that it means."""
        return BodySupport(
            self.boundary, self.gradient, self.translation, ("x" in self.components, "y" in self.components)
        )


UserBody = Annotated[Any, OneOf("body")]
AppliedLoad = Annotated[Any, OneOf("body-load")]


class BodyCase(Section):
    """User-defined bodies, how they are held and loaded, and how that is to be solved.

    Lengths are in the unit of the bodies' dimensions, stresses in the unit of the materials' constants; every other
    unit follows from these two.

    Parameters
    ----------
    title : str
        One line that says what happens.
    source : str
        Where the scene comes from.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path.
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level.
    bodies : tuple of Ring, Disc or Block
        The bodies, at least one; they may touch or overlap, and share nothing even then.
    supports : tuple of SupportEntry
        What is held and moved; a body that nothing holds stays as near to where it was as contact allows.
    loads : tuple of Pressure, Traction or BodyForce
        Pressures and tractions on boundaries, forces in bodies; loads on the same boundary or body add up.
    contact : Penalty, Mortar or NgsolveContact
        What walls do to each other.
    cohesion : Cohesion, optional
        What holds walls together that touch at rest; by default nothing does.
    strategy : Sddp, SingleStep or LoadStepping, optional
        How the load path is followed; by default by single steps, and with cohesion by load stepping.
    accuracy : float
        Relative error that energy, plate force and mean gap may have, > 0; the order of the elements follows
        from it, and a result whose estimated error is larger is not certified. Infinite where nothing is to follow
        from it.
    estimate_error : bool
        Whether errors are estimated, on finer meshes. Where they are not, results are of the mesh of the load path, and
        contact and the end of the continuation follow from `accuracy` alone.
    mesh : BodyMeshChoice
        How finely the bodies are resolved; what is said here is kept.
    observables : tuple of Rotation or SelfContactForce
        What is measured besides what every run measures; each becomes a column and a field.
    expected : tuple of BodyExpected
        Numbers that the case is held to.
    """

    title: str = ""
    source: str = ""
    levels: Levels = 10
    steps: PositiveCount | None = None
    bodies: Annotated[tuple[UserBody, ...], Strict(False), Field(min_length=1)]
    supports: Annotated[tuple[SupportEntry, ...], Strict(False)] = ()
    loads: Annotated[tuple[AppliedLoad, ...], Strict(False)] = ()
    contact: Contact = Field(default_factory=lambda: default_of("contact"))
    cohesion: Cohesion | None = None
    strategy: Strategy | None = None
    accuracy: Accuracy = DEFAULT_ACCURACY
    estimate_error: bool = True
    mesh: BodyMeshChoice = BodyMeshChoice()
    observables: Observables = ()
    expected: Annotated[tuple[BodyExpected, ...], Strict(False)] = ()

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        return level_factors(self.levels)

    @property
    def smallest_step_count(self) -> int:
        """Smallest number of load steps."""
        return self.steps or len(self.level_factors)

    @field_validator("bodies")
    @classmethod
    def _names_and_walls(cls, bodies: tuple[Any, ...]) -> tuple[Any, ...]:
        names = [body.name for body in bodies]
        for number, (name, body) in enumerate(zip(names, bodies, strict=True)):
            if name in names[:number]:
                refuse("is used twice; allowed: a name of its own for each body", number, "name")
            fibres = body.material.fibres
            if fibres is not None and fibres.direction is None:
                allowed = "is missing; allowed: a vector in the plane, from which the angles are measured"
                refuse(allowed, number, "material", "fibres", "direction")
        if not any(body.wall_boundaries for body in bodies):
            refuse("no side of any body may touch; allowed: walls on one body at least", 0, "walls")
        return bodies

    @field_validator("supports", "loads")
    @classmethod
    def _at_known_places(cls, entries: tuple[Any, ...], info: ValidationInfo) -> tuple[Any, ...]:
        boundaries, bodies = _boundaries(info, "boundaries"), [body.name for body in info.data.get("bodies", ())]
        for number, entry in enumerate(entries):
            if entry.boundary is not None:
                _check_name(entry.boundary, boundaries, (number, "boundary"))
            else:
                _check_name(entry.body, bodies, (number, "body"), "is no body")
        return entries

    @field_validator("loads")
    @classmethod
    def _in_the_plane(cls, loads: tuple[Any, ...]) -> tuple[Any, ...]:
        for number, load in enumerate(loads):
            try:
                load.check(2)
            except CaseError as error:
                refuse("{why}", number, why=str(error))
        return loads

    @field_validator("contact", "cohesion")
    @classmethod
    def _goes_with_the_rest(cls, part: Any, info: ValidationInfo) -> Any:
        return in_scope(part, info)

    @field_validator("expected")
    @classmethod
    def _can_be_measured(cls, expected: tuple[BodyExpected, ...], info: ValidationInfo) -> tuple[BodyExpected, ...]:
        supported = [support.boundary for support in info.data.get("supports", ())]
        for number, entry in enumerate(expected):
            if entry.quantity in ROUND:
                round_ones = _boundaries(info, "round_boundaries")
                _check_name(str(entry.boundary), round_ones, (number, "boundary"), "is no arc")
            if entry.quantity in SUPPORTED:
                _check_name(str(entry.boundary), supported, (number, "boundary"), "has no support")
            for side, name in enumerate(entry.between or ()):
                _check_name(name, _boundaries(info, "wall_boundaries"), (number, "between", side), "is no wall")
            _check_level(entry.level, info, number)
        return expected


def _boundaries(info: ValidationInfo, sort: str) -> list[str]:
    """Return the names of all boundaries of a sort; none where the bodies are not as they should be."""
    return [name for body in info.data.get("bodies", ()) for name in getattr(body, sort)]


def _check_name(name: str, known: Iterable[str], place: tuple[str | int, ...], reason: str = "is no boundary") -> None:
    known = list(dict.fromkeys(known))
    if known and name not in known:
        near = get_close_matches(name, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        refuse("{reason}{hint}; allowed: {known}", *place, reason=reason, hint=hint, known=", ".join(known))


def _check_level(level: float | None, info: ValidationInfo, number: int) -> None:
    reported = level_factors(info.data["levels"]) if "levels" in info.data else ()
    if level is not None and reported and not any(isclose(level, factor) for factor in reported):
        levels = ", ".join(f"{factor:g}" for factor in reported)
        refuse("is not reported; allowed: one of the levels ({reported})", number, "level", reported=levels)
