"""What a FEBio deck can say of a case, and what it cannot: the first thing that it cannot say ends the export."""

from __future__ import annotations

from ngcell.errors import CaseError
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.fluid import LumenFluids
from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.mechanics.laws.fibres import ExponentialFibres, QuadraticFibres
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.lumens.fluid import Fluid
from ngcell.mechanics.supports import Support
from ngcell.scene import AnyCase, Case

#: What the deck is silent about, for whoever runs it.
SILENT = (
    "accuracy, certificate and members: the deck has the mesh of the load path, as quadratic elements, and the last "
    "level only",
    "the selection of one equilibrium: where walls part, cells that nothing holds are free in FEBio, whose static "
    "solver may need a small pressure, a dashpot or a weak support",
    "FEBio's own contact, with the default penalty stiffness of this package; its augmentation is off",
)


def check_case(case: AnyCase) -> Case:
    """Return a case that a deck can be written of, as far as that is known before it is built.

    Raises
    ------
    CaseError
        If it cannot; the message names the first reason.
    """
    if not isinstance(case, Case):
        raise _refused("bodies", "a tissue")
    if getattr(case.tissue, "height", None) is not None:
        raise _refused("tissue.height, a third dimension", "a tissue in the plane")
    if case.cohesion is not None:
        raise _refused("cohesion", "walls without bonds")
    laws = {"material": case.material, "lumen.material": getattr(case.lumen, "material", None)}
    for name, law in laws.items():
        if law is not None and not isinstance(law, MooneyRivlin):
            raise _refused(f"{name}, a law of a script", 'kind = "mooney-rivlin"')
        if law is not None and law.fibres is not None and fibres_of(law) is None:
            raise _refused(f"{name}.fibres, a law of a script", 'kind = "exponential" or "quadratic"')
    if isinstance(case.lumen, Fluid) and case.lumen.fill != 1:
        raise _refused(f"lumen.fill = {case.lumen.fill:g}", "1, since FEBio keeps the volume at rest")
    return case


def fibres_of(law: MooneyRivlin) -> ExponentialFibres | QuadraticFibres | None:
    """Return the fibres in a law; None if there are none that a deck can say."""
    return law.fibres if isinstance(law.fibres, (ExponentialFibres, QuadraticFibres)) else None


def check_terms(terms: tuple[object, ...]) -> None:
    """Check that a scene has no energy but that of bodies and of what is in their lumens.

    Raises
    ------
    CaseError
        If it has.
    """
    for term in terms:
        if isinstance(term, AppliedLoads):
            if term.has_others:
                raise _refused("a traction or a body force", "pressures in cells")
        elif not isinstance(term, (BodyEnergy, InclusionEnergy, LumenFluids)):
            raise _refused(f"what {type(term).__name__} stands for", "walls, pressures, fluids and inclusions in cells")


def check_support(support: Support) -> None:
    """Check that a support is a translation, or a deformation about the origin, of both components.

    Raises
    ------
    CaseError
        If it is not.
    """
    if not all(support.components) or (support.gradient.any() and support.translation.any()):
        raise _refused(f"the support {support.region}", "plates, or a frame")


def _refused(what: str, allowed: str) -> CaseError:
    return CaseError(f"export-febio: {what} cannot be said in the deck; allowed: {allowed}")
