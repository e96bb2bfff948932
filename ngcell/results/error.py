"""How far reported numbers are from those of an endless refinement, told from what the refinements so far have changed.

With a remaining share r of the error from one mesh to the next, numbers q on two of them differ by (1 - r) times the
error of the coarser one: the finer one errs by ``|q - q'| r / (1 - r)``. The share is that of the potential, which is
a minimum and falls from mesh to mesh:

- A higher order lowers the errors of all singularities. What the strongest one lets remain is known; where two orders
  in turn have changed the potential by shares that are larger, that is taken. Gaps have a smaller share.
- Grading lowers errors at the corners that it is towards, and no others. Of the error e that was told before, the
  refinement has found the change c: ``1 - c / e`` remains, and never less than at these corners; but of the potential
  no more than `SURE` times what they and the elements that are not split leave (`ngcell.results.elsewhere`), and of
  other numbers as much less. On the meshes after a grade alone the error is also known in two parts
  (`ngcell.results.parts_of_error`); the smaller of the two is told.

Where one refinement only tells the errors of the mesh before, see `ngcell.results.one_refinement`.

No share is taken larger than `MOST_REMAINS`. Another number may stay by accident while the mesh changes: what the
refinement before told of it falls by no more than the share. By accident it stays once, so that nothing older is
remembered; a grade alone does not count, and hands on what it kept. The first mesh is too coarse for what it tells.
Gaps depend on errors elsewhere as well, which a grade towards corners leaves: after a grade alone what was told of them
falls by no more than what the grade has changed. Their mean errs by the same singularities as the energy; it is told no
less than the share `OF_ENERGY` of that, each relative to itself.

Where walls are hardly strained on two meshes in turn, with less energy than anything is told apart from, energies and
forces err by no more than they are. Those that err by all that they are are not judged: nothing is as near to nothing
as is asked for. Changes of gaps are those of the walls that are held on the last mesh.

Beside the mesh, the energy errs by contact that is not rigid, at most by forces times overlaps where no loads act (else
see `ngcell.results.softness`); potentials are those by rigid contact. It also errs by what the proximal term holds;
forces, as its derivatives along the load, and the utilisation of walls by the same share of themselves, and that of
supports by what the proximal term takes of it; and gaps, since walls overlap, by the mean overlap under the forces
between them; a mean gap below zero by no less than itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.report import Check
from ngcell.results.gaps_of_pairs import GapsOfPairs
from ngcell.results.one_refinement import at_least
from ngcell.results.parts_of_error import MOST_REMAINS, Refining, error_in_parts

Array = NDArray[np.float64]

_MEANING = (
    "largest estimated relative error of energy, plate force and mean gap of held walls, by refinement; a mean gap "
    "below 5 % of the wall, where walls do not count as opened, is judged by that"
)


@dataclass(frozen=True, eq=False)
class Numbers:
    """The numbers of one step on one mesh that errors are estimated for.

    Attributes
    ----------
    potential : float
        What the state is a minimum of, as by rigid contact: stored energy and that of loads [stress * length**2].
    energy : float
        Stored energy [stress * length**2].
    plate_force : array of float, shape (dimension,)
        Force of the moved support [stress * length].
    contact_force : float
        Sum of the magnitudes of forces between walls [stress * length].
    mean_gap, largest_gap : float
        Gaps of walls between held bodies [length].
    scales : tuple of float
        Energy and force below which nothing is told apart, and the gap from which on walls count as opened: smaller
        means of gaps err relative to it.
    besides : float
        What the energy may err by besides the mesh [stress * length**2].
    overlap : float
        Mean overlap of walls, weighted by the forces between them [length], >= 0.
    pulled : float
        What the proximal term that is left takes of the force from one support to the other [stress * length].
    utilisation : float
        Largest utilisation of walls [1]; 0 where their strength is not known.
    gaps : GapsOfPairs, optional
        Gaps pair by pair, from which those of other held walls follow.
    stiffer : float
        Share by which rigid contact would change the forces between walls [1], where it is known.
    """

    potential: float
    energy: float
    plate_force: Array
    contact_force: float
    mean_gap: float
    largest_gap: float
    scales: tuple[float, float, float]
    besides: float = 0.0
    overlap: float = 0.0
    pulled: float = 0.0
    utilisation: float = 0.0
    gaps: GapsOfPairs | None = None
    stiffer: float = 0.0

    def over_walls_of(self, last: Numbers) -> Numbers:
        """Return the same with the gaps of the walls whose bodies something holds on the last mesh."""
        told = None if self.gaps is None or last.gaps is None else self.gaps.over_those_of(last.gaps)
        return self if told is None else replace(self, mean_gap=told[0], largest_gap=told[1])

    @property
    def stores_nothing(self) -> bool:
        """Whether walls are hardly strained: the energy is below that from which on anything is told apart."""
        return abs(self.energy) <= self.scales[0]

    @property
    def without_contact(self) -> Numbers:
        """The same without what they err by besides the mesh."""
        return replace(self, besides=0.0, stiffer=0.0, overlap=0.0)


@dataclass(frozen=True)
class Errors:
    """Estimated errors, in the units of the numbers; NaN where none was estimated.

    Attributes
    ----------
    energy, plate_force, contact_force, mean_gap, largest_gap, utilisation : float
        Errors of these numbers; that of the largest utilisation is told and not judged.
    relative : float
        The largest relative error of energy, plate force and mean gap.
    slid : float
        Share of itself by which the mean gap changed as walls were followed to rest, on the mesh of the load path.
    """

    energy: float = nan
    plate_force: float = nan
    contact_force: float = nan
    mean_gap: float = nan
    largest_gap: float = nan
    relative: float = nan
    utilisation: float = nan
    slid: float = 0.0

    def check(self, accuracy: float) -> Check:
        """Return the check of the certificate: a number that is not known fails it."""
        return Check("estimated_error", self.relative if isfinite(self.relative) else inf, accuracy, _MEANING)


NO_ERRORS = Errors()
#: Numbers whose errors are reported.
ERROR_NAMES = ("energy", "plate_force", "contact_force", "mean_gap", "largest_gap")
_GAPS = ("mean_gap", "largest_gap")
_REPORTED = ("utilisation", *ERROR_NAMES)
_TOLD = ("potential", *_REPORTED)
#: How often the sum of parts is told after a grade alone: finest meshes have found 1.6 times it (corners outside).
SURE = 1.75
#: Least relative error of a mean gap over that of the energy. Of 16 runs that were taken on to the finest mesh 13 err
#: by less than this share of what is told of the energy; of the other three the meshes tell more (docs/accuracy.md).
OF_ENERGY = 1 / 3


def estimate(
    found: Sequence[Numbers], refined: Sequence[Refining], *, of_last: bool = True, meant: Numbers | None = None
) -> Errors:
    """Return the errors of numbers that were found on one mesh after the other.

    Parameters
    ----------
    found : sequence of Numbers
        On each mesh, the coarsest first.
    refined : sequence of Refining
        How each mesh but the first is finer than the one before.
    of_last : bool
        Whether errors are those of the last mesh, or of the last but one.
    meant : Numbers, optional
        Those of the last mesh by the contact that is meant, where the others are by one that leads to it.
    """
    if len(found) < 2:
        return Errors()
    found = [one.over_walls_of(meant or found[-1]) for one in found]
    changes = [{name: _change(one, two, name) for name in _TOLD} for one, two in zip(found, found[1:], strict=False)]
    of_energies = _chain(changes, refined, of_last)
    of_gaps = _chain(changes, [how.of_gaps for how in refined], of_last)
    new = {name: (of_gaps if name in _GAPS else of_energies)[name] for name in _TOLD}
    if not of_last:
        before = found[-2]
        forces = {name: getattr(before, name) for name in ("plate_force", "contact_force")}
        new = at_least(new, max(abs(before.energy), before.scales[0]), forces, (before.gaps, found[-1].gaps))
    at_most, told_of = _in_parts(changes, refined) if of_last else {}, found[-1 if of_last else -2]
    is_nothing = all(one.stores_nothing for one in found[-2:])
    if is_nothing:
        at_most |= {name: _size(getattr(told_of, name)) for name in _TOLD if name not in _GAPS}
    new = {name: min(new[name], at_most.get(name, inf)) for name in _TOLD}
    return _with_contact(meant or told_of, new, is_nothing=is_nothing)


def _chain(changes: Sequence[Mapping[str, float]], refined: Sequence[Refining], of_last: bool) -> dict[str, float]:
    """Return the errors that follow from what each refinement has changed, and from what the one before told."""
    told, of_before, new = dict[str, float](), dict[str, float](), dict[str, float]()
    changed = 0.0
    for number, (change, how) in enumerate(zip(changes, refined, strict=False)):
        share = _share(how, change["potential"], changed, told.get("potential"))
        remains = share if of_last else 1.0
        alone = {name: change[name] * remains / (1 - share) for name in _TOLD}
        new = {name: max(alone[name], _kept(name, how, share, change, of_before)) for name in _TOLD}
        if of_last and number and how.unsplit is not None:
            at_most = _beside_corners(change["potential"], changes[number - 1]["potential"], how, refined[number - 1])
            cut = min(1.0, at_most / new["potential"]) if new["potential"] else 1.0
            new |= {name: cut * new[name] for name in _TOLD if name not in _GAPS}
        told, changed = new if number else {}, 0.0 if how.is_graded else change["potential"]
        of_before = {} if not number else new if how.is_graded_alone else alone
    return new


def _kept(
    name: str, how: Refining, share: float, change: Mapping[str, float], of_before: Mapping[str, float]
) -> float:
    """Return what a refinement leaves at least of the error of a number that the one before told."""
    told = of_before.get(name, 0.0)
    by_change = told - change[name] if name in _GAPS and how.is_graded_alone else 0.0
    return max(share * told, by_change)


def _beside_corners(change: float, before: float, grade: Refining, order: Refining) -> float:
    """Return what the potential errs by at most after a grade alone, from what it and the order before have changed.

    It errs by what the grade leaves at the corners, and by what the order has left in elements that the grade does not
    split; the sum is taken `SURE` times.
    """
    corners = change * grade.remains / (1 - grade.remains)
    others = before * (grade.unsplit or 0.0) * order.elsewhere / (1 - order.elsewhere)
    return SURE * (corners + others)


def _in_parts(changes: Sequence[Mapping[str, float]], refined: Sequence[Refining]) -> dict[str, float]:
    """Return errors that follow from that of the potential in parts; nothing where the parts are not known.

    What a refinement has changed a number by, relative to what it has changed the potential by, what is left may
    change it by as well: by the largest of these ratios, that of the first mesh left out, whichever refinement.
    """
    of_potential = [change["potential"] for change in changes]
    left = error_in_parts(of_potential, refined[: len(changes)])
    if left is None or min(of_potential) <= 0:
        return {}
    return {name: left * max(change[name] / change["potential"] for change in changes[1:]) for name in _TOLD}


def _share(how: Refining, change: float, before: float, told: float | None) -> float:
    """Return the share of the error that a refinement has left.

    `change` is that of the potential, `before` that by the order before, `told` the error that it was told then.
    """
    if how.is_graded and told:
        measured = 1 - change / told
    else:
        measured = change / before if before > 0 else 0.0
    return min(max(measured, how.remains), MOST_REMAINS)


def _with_contact(last: Numbers, told: dict[str, float], *, is_nothing: bool) -> Errors:
    """Return errors of the mesh with those of contact and the proximal term."""
    softness = last.besides / max(abs(last.energy), last.scales[0])
    plate = float(np.linalg.norm(last.plate_force))
    besides = {
        "energy": last.besides,
        "plate_force": softness * plate + last.pulled,
        "contact_force": max(softness, last.stiffer) * last.contact_force,
        "mean_gap": max(last.overlap, -last.mean_gap),
        "largest_gap": last.overlap,
        "utilisation": softness * last.utilisation,
    }
    like_energy = told["energy"] / max(abs(last.energy), last.scales[0]) * abs(last.mean_gap)
    least = told | {"mean_gap": max(told["mean_gap"], OF_ENERGY * like_energy)}
    return _judged(last, {name: least[name] + besides[name] for name in besides}, is_nothing=is_nothing)


def _judged(last: Numbers, told: Mapping[str, float], *, is_nothing: bool) -> Errors:
    """Return errors with the largest relative one; nothing that errs by all that it is is left out."""
    energy, force, gap = last.scales
    plate = float(np.linalg.norm(last.plate_force))
    sizes = {"energy": (abs(last.energy), energy), "plate_force": (plate, force)}
    judged = [told[name] / max(each) for name, each in sizes.items() if not (is_nothing and told[name] >= each[0])]
    return Errors(**told, relative=float(np.max([*judged, told["mean_gap"] / max(abs(last.mean_gap), gap)])))


def errors_beside(errors: Errors, there: Numbers, here: Numbers) -> Errors:
    """Return the errors of a state beside another on the same mesh, which the errors are of.

    They are larger by what has changed from there to here: meshes may lead to either.
    """
    there = there.over_walls_of(here)
    told = {name: getattr(errors, name) + _change(there, here, name) for name in _REPORTED}
    return _judged(here, told, is_nothing=there.stores_nothing and here.stores_nothing)


def _change(one: Numbers, two: Numbers, name: str) -> float:
    return _size(getattr(two, name) - getattr(one, name))


def _size(number: float | Array) -> float:
    return float(np.linalg.norm(np.atleast_1d(number)))
