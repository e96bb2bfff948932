"""How far a result depends on the penalty stiffness: the last level once more, with stiffer penalty terms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ngcell.build.additions import Additions
from ngcell.clock import Clock
from ngcell.errors import CaseError
from ngcell.results.report import StepReport
from ngcell.scene import AnyCase, BodyScene, Case, Mortar

#: Factor on the stiffness. Errors of a penalty fall in proportion to it, so what moves is nearly the whole error.
STIFFER = 10.0

_COMPARED = ("energy", "plate_force_x", "plate_force_y", "contact_force", "mean_gap", "largest_gap", "parted_pairs")


def check_has_penalty(case: AnyCase | BodyScene) -> None:
    """Check that there is a penalty to verify.

    Raises
    ------
    CaseError
        If contact is by the mortar method, whose result knows no stiffness.
    """
    if isinstance(case.contact, Mortar):
        raise CaseError("contact.kind = 'mortar' has no penalty to verify; allowed: contact.kind = 'penalty'")


def stiffer_result(
    case: AnyCase | BodyScene,
    additions: Additions,
    last: StepReport,
    raised: float = 1.0,
    *,
    end: float | None = None,
) -> dict[str, Any]:
    """Return what the last level of a case becomes with a stiffer penalty.

    Parameters
    ----------
    case : Case, BodyCase or BodyScene
        The case, with contact by penalty.
    additions : Additions
        What a script adds to it.
    last : StepReport
        Its last accepted step, at its own stiffness.
    raised : float
        Factor by which penalty terms had been made stiffer by the end of the run, since they were too soft.
    end : float, optional
        When that has to end, as `time.monotonic` tells it [s].

    Returns
    -------
    dict
        The factor on the stiffness and, for each compared column of the history, the value as it was, with stiffer
        penalty terms, and the difference over the former (``None`` where that is zero). Levels of a tissue do not
        depend on each other, so the last one is run alone; user-defined bodies follow all of theirs.

    Raises
    ------
    StepFailed
        If the stiffer problem finds no equilibrium.
    OutOfTime
        If it takes too long.
    """
    contact = case.contact.model_copy(update={"stiffness": STIFFER * raised * case.contact.stiffness})
    stiffer: AnyCase | BodyScene
    if isinstance(case, BodyScene):
        stiffer = replace(case, contact=contact)
    else:
        stiffer = case.model_copy(update={"contact": contact, "expected": ()})
    if isinstance(case, Case):
        load = case.load.model_copy(update={"levels": (case.level_factors[-1],)})
        stiffer = case.model_copy(update={"contact": contact, "expected": (), "load": load})
    *_, step = additions.simulation(stiffer, Clock(end)).accepted_steps()
    overlaps = [_overlap(taken) for taken in (last, step.report)]
    table = {name: _compared(getattr(last.record, name), getattr(step.record, name)) for name in _COMPARED}
    return {"stiffness_factor": STIFFER, **table, "penetration_over_wall": _compared(*overlaps)}


def _overlap(step: StepReport) -> float:
    checks = step.certificate.checks
    return next(check.value for check in checks if check.name == "penetration_over_wall")


def _compared(meant: float, stiffer: float) -> dict[str, float | None]:
    return {"meant": meant, "stiffer": stiffer, "change": (stiffer - meant) / abs(meant) if meant else None}
