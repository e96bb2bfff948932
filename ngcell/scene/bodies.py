"""Own bodies: shapes that a user drew, each with its material, and the supports and loads that move them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ngcell.errors import CaseError
from ngcell.scene.accuracy import DEFAULT_ACCURACY
from ngcell.scene.entries import (
    NUMBERS,
    check_dimension,
    check_name,
    check_numbers,
    check_unique_names,
    entries_of,
    is_number,
    sequence_of,
)
from ngcell.scene.levels import Levels
from ngcell.scene.mesh import HIGHEST_ORDER, PLAIN_BODY_ORDER, Refinement
from ngcell.scene.registry import checked, default_of, each_checked

#: Two numbers, or three for solids.
Numbers = tuple[float, float] | tuple[float, float, float]
Gradient = tuple[Numbers, ...]

_LEVELS: TypeAdapter[int | tuple[float, ...]] = TypeAdapter(Levels, config={"defer_build": True})


@dataclass(frozen=True, eq=False)
class Body:
    """One body.

    Parameters
    ----------
    shape : object
        A planar face of `netgen.occ` in the plane z = 0, or a solid [length]; all bodies alike. Edges of the face, or
        faces of the solid, that have a name can be supported by it; ``maxh`` on them refines the mesh there.
    material : MooneyRivlin or HyperelasticLaw
        What it is made of.
    name : str
        Letters, digits, ``_`` and ``-``.
    untouched : tuple of str
        Names of edges that nothing will touch, such as planes of symmetry: they are no walls.
    walls : tuple of str
        Names of edges that stay walls even where they are guided: held in the plane that they lie in, with all bodies
        on one side of it. By default nothing can touch those.
    """

    shape: Any
    material: Any
    name: str
    untouched: tuple[str, ...] = ()
    walls: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_name(self.name, "body name")
        for what in ("untouched", "walls"):
            for edge in sequence_of(getattr(self, what), str, f"body {self.name}: {what}"):
                check_name(edge, f"body {self.name}: {what} edge")
        checked("material", self.material, f"body {self.name}: material")


@dataclass(frozen=True)
class BodySupport:
    """A boundary whose displacement is ``load_factor * (gradient @ X + translation)`` at the reference position X.

    Parameters
    ----------
    boundary : str
        Name of an edge, or of a solid's face; for those without one, ``<body>_outline`` or ``<body>_hole0``,
        ``<body>_hole1``, ...
    gradient : tuple of tuple of float, shape (dimension, dimension)
        Displacement gradient at load factor 1, without unit.
    translation : tuple of float, shape (dimension,)
        Displacement of the origin at load factor 1 [length].
    components : tuple of bool, shape (dimension,)
        Which components are prescribed; the others are free. Where supports meet, the later one counts.
    """

    boundary: str
    gradient: Gradient = ((0.0, 0.0), (0.0, 0.0))
    translation: Numbers = (0.0, 0.0)
    components: tuple[bool, ...] = (True, True)

    def __post_init__(self) -> None:
        check_name(self.boundary, "boundary of a support")
        place = f"support {self.boundary}"
        allowed = "two rows of two finite numbers, or three of three for solids"
        rows = entries_of(self.gradient, f"{place}: gradient", allowed)
        for row in rows:
            check_numbers(row, f"{place}: gradient", allowed)
            if len(row) != len(rows):
                raise CaseError(f"{place}: gradient is {self.gradient!r}; allowed: {allowed}")
        check_numbers(self.translation, f"{place}: translation", NUMBERS)
        allowed = "two booleans, or three for solids, at least one of them True"
        components = entries_of(self.components, f"{place}: components", allowed)
        if not all(isinstance(entry, bool) for entry in components) or not any(components):
            raise CaseError(f"{place}: components is {self.components!r}; allowed: {allowed}")

    @property
    def moves(self) -> bool:
        """Whether the support moves at all."""
        return any(value != 0 for row in (*self.gradient, self.translation) for value in row)

    def of_bodies(self, dimension: int) -> BodySupport:
        """Return the support of bodies of this dimension: what was left out is held in all directions.

        Raises
        ------
        CaseError
            If what was given has another dimension.
        """
        still, whole = (0.0,) * dimension, (True,) * dimension
        held: dict[str, Any] = {"gradient": (still,) * dimension, "translation": still, "components": whole}
        defaults = {entry.name: entry.default for entry in fields(self)}
        left_out = {name: value for name, value in held.items() if getattr(self, name) == defaults[name]}
        for name in held.keys() - left_out.keys():
            check_dimension(getattr(self, name), f"support {self.boundary}: {name}", dimension)
        return replace(self, **left_out)


@dataclass(frozen=True, eq=False)
class BodyScene:
    """Bodies, what moves them, and how finely they are resolved.

    Parameters
    ----------
    bodies : sequence of Body
        At least one; they may touch, and share nothing even then.
    supports : sequence of BodySupport
        What is held and moved; a body that nothing holds stays as near to where it was as contact allows.
    size : float, optional
        Largest length of an element's edge, > 0; by default half of each body's own thickness.
    order : int, optional
        Polynomial order of displacement and geometry, 1 to 6; by default it follows from the accuracy.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path.
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level.
    contact : Penalty, Mortar, NgsolveContact or ContactChoice
        What walls do to each other.
    loads : sequence of Pressure, Traction, BodyForce or AppliedLoad
        Pressures and tractions on boundaries, forces in bodies; loads on the same boundary or body add up.
    refinements : sequence of Refinement
        Where elements are smaller.
    cohesion : Cohesion or CohesiveLaw, optional
        What holds walls together that touch at rest; by default nothing does.
    strategy : Strategy, optional
        How the load path is followed; by default by single steps, and with cohesion by load stepping.
    observables : sequence of Observable
        What is measured besides what every run measures.
    title : str
        One line that says what happens.
    accuracy : float
        Relative error that energy, plate force and mean gap may have, > 0; infinite where nothing is to follow from it.
    estimate_error : bool
        Whether errors are estimated, by elements of higher orders.

    Raises
    ------
    CaseError
        If a value is not allowed.
    """

    bodies: Sequence[Body]
    supports: Sequence[BodySupport] = ()
    size: float | None = None
    order: int | None = None
    levels: int | tuple[float, ...] = 10
    steps: int | None = None
    contact: Any = field(default_factory=lambda: default_of("contact"))
    loads: Sequence[Any] = ()
    refinements: Sequence[Refinement] = ()
    cohesion: Any = None
    strategy: Any = None
    observables: Sequence[Any] = ()
    title: str = ""
    accuracy: float = DEFAULT_ACCURACY
    estimate_error: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "bodies", sequence_of(self.bodies, Body, "bodies"))
        object.__setattr__(self, "supports", sequence_of(self.supports, BodySupport, "supports"))
        object.__setattr__(self, "loads", each_checked("body-load", self.loads, "loads"))
        object.__setattr__(self, "refinements", sequence_of(self.refinements, Refinement, "refinements"))
        if not self.bodies:
            raise CaseError("bodies is empty; allowed: at least one body")
        check_unique_names(body.name for body in self.bodies)
        known = [body.name for body in self.bodies]
        unknown = {load.body for load in self.loads if load.body is not None} - set(known)
        if unknown:
            names = ", ".join(known)
            raise CaseError(f"load in {min(unknown)}: there is no such body; allowed: {names}")
        if self.size is not None and not (is_number(self.size) and self.size > 0):
            raise CaseError(f"size is {self.size!r}; allowed: a finite length > 0")
        if self.order is not None and (type(self.order) is not int or not 1 <= self.order <= HIGHEST_ORDER):
            raise CaseError(f"order is {self.order!r}; allowed: a whole number from 1 to {HIGHEST_ORDER}")
        if not isinstance(self.accuracy, (int, float)) or not self.accuracy > 0:
            raise CaseError(f"accuracy is {self.accuracy!r}; allowed: a number > 0, or infinity")
        if self.steps is not None and (type(self.steps) is not int or self.steps < 1):
            raise CaseError(f"steps is {self.steps!r}; allowed: a whole number >= 1")
        checked("contact", self.contact, "contact")
        object.__setattr__(self, "observables", each_checked("observable", self.observables, "observables"))
        if self.strategy is not None:
            checked("strategy", self.strategy, "strategy")
        if self.cohesion is not None:
            checked("cohesion", self.cohesion, "cohesion")
            if not self.contact.goes_with_cohesion:
                raise CaseError(f"cohesion does not go with contact {self.contact!r}; allowed: a Penalty")
        _check_levels(self.levels)

    @property
    def plain_order(self) -> int:
        """The order that is given, or else the one where no error is to be estimated."""
        return self.order or PLAIN_BODY_ORDER

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        levels = _LEVELS.validate_python(self.levels)
        return tuple((n + 1) / levels for n in range(levels)) if isinstance(levels, int) else levels

    @property
    def smallest_step_count(self) -> int:
        """Smallest number of load steps."""
        return self.steps or len(self.level_factors)

    @property
    def moved_boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries that a support moves, each once."""
        return tuple(dict.fromkeys(support.boundary for support in self.supports if support.moves))


def _check_levels(levels: object) -> None:
    try:
        _LEVELS.validate_python(levels)
    except ValidationError as error:
        raise CaseError(f"levels is {levels!r}; {error.errors()[0]['msg']}") from None
