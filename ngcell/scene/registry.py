"""The registry of kinds: for each group of a case's parts, which kinds there are and where each is realised.

A kind is one class: a frozen pydantic section whose key `kind` names it, and whose methods do what it says. A further
kind of the package is one file in the room that realises it and one line in `_SHIPPED`. A user's script adds a kind of
its own by `register`, or hands over an object that offers the methods that its group asks for.

Nothing is imported before a case needs it: the lines name modules and classes by text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from importlib import import_module
from typing import Any, TypeVar

from pydantic import BaseModel

from ngcell.errors import CaseError

Section = TypeVar("Section", bound=type[BaseModel])


@dataclass(frozen=True)
class Group:
    """The kinds of one part of a case.

    Attributes
    ----------
    kinds : dict of str to str
        Where each kind of the package is, as ``module:Class``.
    default : str, optional
        Kind of a table that names none; by default a table has to name one.
    protocol : str, optional
        What an object of a user has to offer, as ``module:Protocol``; by default it has to be of a registered class.
    own : dict of str to type
        Kinds that a script registered.
    """

    kinds: Mapping[str, str]
    default: str | None = None
    protocol: str | None = None
    own: dict[str, type[BaseModel]] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """All kinds, those of the package first."""
        return list(dict.fromkeys([*self.kinds, *self.own]))

    def section(self, kind: str) -> type[BaseModel]:
        """Return the class of a kind, imported now if nobody needed it before."""
        section: type[BaseModel] = self.own.get(kind) or _loaded(self.kinds[kind])
        return section

    def holds(self, value: object) -> bool:
        """Return whether an object is of a registered class, or offers what the group asks for."""
        kind = getattr(value, "kind", None)
        if isinstance(value, BaseModel) and kind in self.names and isinstance(value, self.section(str(kind))):
            return True
        return self.protocol is not None and isinstance(value, _loaded(self.protocol))

    @property
    def allowed(self) -> str:
        """What an object may be, in words."""
        words = "a " + " or a ".join(self.section(kind).__name__ for kind in self.names)
        if self.protocol is None:
            return words
        offered = sorted(name for name in _members(_loaded(self.protocol)) if not name.startswith("_"))
        return f"{words}, or an object that offers {', '.join(offered)}"


_SHIPPED = {
    "tissue": Group(
        {
            "honeycomb": "ngcell.geometry.tissues.honeycomb:Tissue",
            "perturbed": "ngcell.geometry.tissues.perturbed:Perturbed",
            "brick": "ngcell.geometry.tissues.brick:Brick",
            "voronoi": "ngcell.geometry.tissues.voronoi:Voronoi",
            "polygons": "ngcell.geometry.tissues.polygon_file:Polygons",
            "image": "ngcell.geometry.tissues.label_image:LabelImage",
        },
        default="honeycomb",
        protocol="ngcell.geometry.tissues.protocol:TissueGeometry",
    ),
    "body": Group(
        {
            "ring": "ngcell.geometry.user_bodies.ring:Ring",
            "disc": "ngcell.geometry.user_bodies.disc:Disc",
            "block": "ngcell.geometry.user_bodies.block:Block",
        },
    ),
    "material": Group(
        {"mooney-rivlin": "ngcell.mechanics.laws.mooney_rivlin:MooneyRivlin"},
        protocol="ngcell.mechanics.laws.law:HyperelasticLaw",
    ),
    "fibres": Group(
        {
            "exponential": "ngcell.mechanics.laws.fibres:ExponentialFibres",
            "quadratic": "ngcell.mechanics.laws.fibres:QuadraticFibres",
        },
        protocol="ngcell.mechanics.laws.law:FibreLaw",
    ),
    "lumen": Group(
        {
            "pressure": "ngcell.mechanics.lumens.pressure:CellPressure",
            "inclusion": "ngcell.mechanics.lumens.inclusion:Inclusion",
            "fluid": "ngcell.mechanics.lumens.fluid:Fluid",
        },
        protocol="ngcell.mechanics.lumens.lumen:LumenContents",
    ),
    "load": Group(
        {
            "plates": "ngcell.mechanics.loading.plates:Plates",
            "frame": "ngcell.mechanics.loading.frame:Frame",
            "ends": "ngcell.mechanics.loading.ends:Ends",
            "indenter": "ngcell.mechanics.loading.indenter:Indenter",
        },
        protocol="ngcell.mechanics.loading.load:TissueLoad",
    ),
    "body-load": Group(
        {
            "pressure": "ngcell.mechanics.applied.boundary_pressure:Pressure",
            "traction": "ngcell.mechanics.applied.traction:Traction",
            "body-force": "ngcell.mechanics.applied.body_force:BodyForce",
        },
        protocol="ngcell.mechanics.applied.protocol:AppliedLoad",
    ),
    "strategy": Group(
        {
            "sddp": "ngcell.solve.strategies.sddp:Sddp",
            "single-step": "ngcell.solve.strategies.single_step:SingleStep",
            "load-stepping": "ngcell.solve.strategies.load_stepping:LoadStepping",
        },
        default="sddp",
        protocol="ngcell.solve.strategies.strategy:Strategy",
    ),
    "observable": Group(
        {
            "rotation": "ngcell.results.observables.rotation:Rotation",
            "self-contact-force": "ngcell.results.observables.self_contact_force:SelfContactForce",
        },
        protocol="ngcell.results.observables.observable:Observable",
    ),
    "contact": Group(
        {
            "penalty": "ngcell.contact.methods.by_penalty:Penalty",
            "mortar": "ngcell.contact.methods.by_mortar:Mortar",
            "ngsolve": "ngcell.contact.methods.by_ngsolve:NgsolveContact",
        },
        default="penalty",
        protocol="ngcell.contact.methods.stages:ContactChoice",
    ),
    "cohesion": Group(
        {"exponential": "ngcell.contact.cohesion.exponential:Cohesion"},
        default="exponential",
        protocol="ngcell.contact.cohesion.law:CohesiveLaw",
    ),
    "axis": Group(
        {
            "grid": "ngcell.sweeps.axes:Grid",
            "range": "ngcell.sweeps.axes:Range",
            "log-range": "ngcell.sweeps.axes:LogRange",
            "random": "ngcell.sweeps.axes:Random",
            "zip": "ngcell.sweeps.joint_axes:Zip",
            "latin-hypercube": "ngcell.sweeps.joint_axes:LatinHypercube",
        },
        protocol="ngcell.sweeps.axis:Axis",
    ),
}


def group(name: str) -> Group:
    """Return a group of kinds.

    Raises
    ------
    CaseError
        There is no such group.
    """
    if name not in _SHIPPED:
        near = get_close_matches(name, _SHIPPED, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise CaseError(f"{name!r} is no group of kinds{hint}; allowed: {', '.join(_SHIPPED)}")
    return _SHIPPED[name]


def register(name: str, section: Section) -> Section:
    """Add a kind to a group, for case files and for Python alike; return its class.

    Parameters
    ----------
    name : str
        The group: "material", "cohesion", "contact", ...
    section : type
        A frozen pydantic model with a field ``kind: Literal["<kind>"] = "<kind>"`` and the methods that the group's
        kinds have. A kind that was registered before is replaced.

    Raises
    ------
    CaseError
        There is no such group, the class has no kind, or the kind is one of the package.
    """
    known = group(name)
    model_field = getattr(section, "model_fields", {}).get("kind")
    kind = None if model_field is None else model_field.default
    if not isinstance(kind, str):
        allowed = 'a pydantic model with a field `kind: Literal["..."] = "..."`'
        raise CaseError(f"{section!r} names no kind of {name}; allowed: {allowed}")
    if kind in known.kinds:
        raise CaseError(
            f"{name} kind {kind!r} is one of the package; allowed: a name other than {', '.join(known.kinds)}"
        )
    known.own[kind] = section
    return section


def registered() -> tuple[type[BaseModel], ...]:
    """Return the classes that scripts have registered so far."""
    return tuple(section for known in _SHIPPED.values() for section in known.own.values())


def default_kind(name: str) -> str | None:
    """Return the kind of a table of that name which names none, if there is one."""
    return _SHIPPED[name].default if name in _SHIPPED else None


def default_of(name: str) -> Any:
    """Return the part that a case has where it says nothing: the default kind of a group, with its own defaults."""
    known = group(name)
    return known.section(str(known.default))()


def checked(name: str, value: object, place: str) -> Any:
    """Return an object that can stand in a group's place.

    Raises
    ------
    CaseError
        It cannot; the message names `place`.
    """
    known = group(name)
    if not known.holds(value):
        raise CaseError(f"{place} is {value!r}; allowed: {known.allowed}")
    return value


def each_checked(name: str, values: object, place: str) -> tuple[Any, ...]:
    """Return a list of objects that can stand in a group's place as a tuple.

    Raises
    ------
    CaseError
        It is no list, or one of them cannot; the message names `place`.
    """
    if not isinstance(values, (list, tuple)):
        raise CaseError(f"{place} is {values!r}; allowed: a list, each entry {group(name).allowed}")
    return tuple(checked(name, value, f"{place}[{number}]") for number, value in enumerate(values))


def section_named(name: str) -> type[BaseModel] | None:
    """Return the class of that name among the kinds of the package, None if there is none."""
    for known in _SHIPPED.values():
        for place in known.kinds.values():
            if place.partition(":")[2] == name:
                section: type[BaseModel] = _loaded(place)
                return section
    return None


def section_names() -> list[str]:
    """Return the names of the classes of all kinds of the package."""
    return sorted(place.partition(":")[2] for known in _SHIPPED.values() for place in known.kinds.values())


def _loaded(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def _members(protocol: type) -> set[str]:
    own = {name for cls in protocol.__mro__ if getattr(cls, "_is_protocol", False) for name in vars(cls)}
    return own | set(getattr(protocol, "__annotations__", {}))
