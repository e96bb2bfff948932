"""The error of a potential in two parts: that of corners that grading is towards, and that of all other singularities.

Grading alone, without a higher order, lowers the first part only, by a share that its singularity tells; so it tells
how large that part is. Each refinement after it lowers the first part by a share that is known, and what else it
changes is of the second: of the ends of contact, and of corners that press on walls. Its share is that which it had
from the refinement before, and never less than that of a crack or a punch, the strongest of all. Where a refinement
both grades and raises the order, which part its change is of is not known: both fall by their shares, and what it
changes beyond that counts as one of the second part that had not been told. So what was told too large on coarse
meshes is not kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

#: The largest share of an error that a refinement is taken to leave.
MOST_REMAINS = 0.8


@dataclass(frozen=True)
class Refining:
    """How a mesh is finer than the one before.

    Attributes
    ----------
    remains : float
        Smallest share of the error that it may leave, in (0, 1); of that of graded corners it leaves this share.
    is_graded : bool
        Whether it is graded towards corners once more.
    elsewhere : float
        Smallest share that it may leave of errors elsewhere; 1 where it does nothing there.
    unsplit : float, optional
        Of what the refinement before changed, the share in elements that this one, graded alone, leaves as they are;
        by default it is not known.
    remains_of_gaps : float, optional
        Smallest share of the errors of gaps that it may leave; by default the same.
    """

    remains: float
    is_graded: bool = False
    elsewhere: float = 0.0
    remains_of_gaps: float | None = None
    unsplit: float | None = None

    @property
    def of_gaps(self) -> Refining:
        """The same as gaps see it."""
        return self if self.remains_of_gaps is None else replace(self, remains=self.remains_of_gaps)

    @property
    def unmeasured(self) -> Refining:
        """The same with no less left than by the strongest singularity: a single refinement measures no share."""
        of_gaps = max(self.of_gaps.remains, self.elsewhere)
        return replace(self, remains=max(self.remains, self.elsewhere), remains_of_gaps=of_gaps)

    @property
    def is_graded_alone(self) -> bool:
        """Whether it is graded, and does nothing elsewhere."""
        return self.is_graded and self.elsewhere == 1


def error_in_parts(changes: Sequence[float], refined: Sequence[Refining]) -> float | None:
    """Return the error of the potential that the last refinement leaves; None where no grading has told its parts.

    Parameters
    ----------
    changes : sequence of float
        By how much each refinement has changed the potential [energy], >= 0.
    refined : sequence of Refining
        These refinements.
    """
    alone = [number for number, how in enumerate(refined) if how.is_graded_alone]
    if not alone or alone[-1] + 1 >= len(changes):
        return None
    first = alone[-1]
    corners = changes[first] * refined[first].remains / (1 - refined[first].remains)
    before, others, share = 0.0, 0.0, 0.0
    for change, how in zip(changes[first + 1 :], refined[first + 1 :], strict=True):
        other = max(change - corners * (1 - how.remains), 0.0)
        if how.is_graded:
            share = max(share, how.elsewhere)
            untold, before = max(other - others * (1 - share), 0.0), 0.0
            others = share * others + untold * share / (1 - share)
        else:
            measured = other / before if before > 0 else 0.0
            share = min(max(measured, how.elsewhere), MOST_REMAINS)
            others, before = other * share / (1 - share), other
        corners *= how.remains
    return max(corners + others, changes[-1] * refined[-1].remains / (1 - refined[-1].remains))
