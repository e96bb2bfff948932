"""The numbers of contact that no case names, as one record that is handed down."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf


@dataclass(frozen=True)
class ContactOptions:
    """The solver's own numbers of contact; stiffness of penalty terms is in layers of elements behind the wall.

    Attributes
    ----------
    facing : float
        Facets face each other while the product of the normals of their chords is below this, in (-1, 0): by default
        while they differ from opposite by less than about 37 degrees. A corner that presses with a steeper angle acts
        at its tip.
    between : float
        Overlap between the points of the penalty method's rule over that at them, above which the rule is to blame,
        not the penalty terms, > 1.
    allowed : float
        How deep a point constraint of the mortar method may sink in, as a share of the size of its facet, > 0.
    covered : float
        Share of the integral of a function of the mortar method that other walls have to cover for it to have a
        multiplier, in [0, 1).
    penalty_multiple : float
        Stiffness of the penalty method that is meant, > 0, and of the one from which the mortar method takes over: as
        stiff as the accuracy asks, so that the equilibria on finer meshes are those of the penalty method.
    most_multiple : float
        The largest stiffness that accuracy makes of it, at which penalty terms still find a way down at corners, > 0.
    path_multiple : float
        Stiffness with which continuation paths are followed, > 0: as stiff as the layer behind the wall, it costs a
        third of the iterations.
    soft : float
        Overlap over the thinner body's thickness above which penalty terms are too soft, in (0, 0.02]: a certificate
        allows 0.02, and outlines may overlap deeper than points tell.
    stored, stored_before : float
        Share of the stored energy that penalty terms may store without being too soft, > 0; and that of those from
        which the mortar method takes over, which may overlap as deep as they do.
    stage_factor : float
        Factor between the stages from there to the one that is meant, > 1.
    mortar_multiple : float
        Stiffness of the mortar method, > 0. The result does not depend on it: softer terms need more updates of the
        multipliers, stiffer ones more steps to each.
    only_leads : bool
        Whether equilibria only lead to those on finer meshes: then a penalty stands for the mortar method.
    """

    facing: float = -0.8
    between: float = 2.0
    allowed: float = 2.5e-4
    covered: float = 0.01
    penalty_multiple: float = 10.0
    most_multiple: float = 1e3
    path_multiple: float = 1.0
    soft: float = 0.015
    stored: float = 0.01
    stored_before: float = 0.1
    stage_factor: float = 10.0
    mortar_multiple: float = 3.0
    only_leads: bool = False

    @property
    def before_multipliers(self) -> ContactOptions:
        """The numbers of the penalty from which the mortar method takes over."""
        return replace(self, soft=inf, stored=self.stored_before)

    def path_multiples(self, meant: float) -> list[float]:
        """Return the stiffnesses of the stages before the one that is meant, the softest first; at least one."""
        multiples, multiple = [], self.path_multiple
        while multiple < meant * (1 - 1e-9):
            multiples.append(multiple)
            multiple *= self.stage_factor
        return multiples or [meant]


#: What is used unless somebody hands down other numbers.
DEFAULT_OPTIONS = ContactOptions()
