"""How far a result depends on what an equilibrium should not: the same once more, with another penalty or mesh.

Nothing of a run changes by it. A stiffer penalty tells what its overlaps cost. Elements of one order more tell the
error of a mesh that no estimate is made for, as where bonds remember how they were loaded. Where one is made, the last
level is taken on from where it ended to the finest mesh, whose numbers tell whether the error was told right.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot
from typing import Any

from ngcell.build.additions import Additions
from ngcell.build.meshed import step_numbers
from ngcell.build.stages import not_estimated, one_order_more, singular_exponent, stages_of
from ngcell.clock import Clock
from ngcell.errors import CaseError
from ngcell.results.record import StepRecord
from ngcell.results.report import StepReport
from ngcell.scene import AnyCase, BodyScene, Case
from ngcell.scene.section import Section

#: Factor on the stiffness. Errors of a penalty fall in proportion to it, so what moves is nearly the whole error.
STIFFER = 10.0

_COMPARED = ("energy", "plate_force_x", "plate_force_y", "contact_force", "mean_gap", "largest_gap", "parted_pairs")
#: Numbers that have an error of the mesh, beside the plate force.
_OF_MESH, _OF_BONDS = ("energy", "contact_force", "mean_gap", "largest_gap"), ("separation_energy", "dissipation")

Table = dict[str, Any]


def check_has_penalty(case: AnyCase | BodyScene) -> None:
    """Check that there is a penalty to verify.

    Raises
    ------
    CaseError
        If contact is by the mortar method, whose result knows no stiffness, or by a law or method of a script.
    """
    contact = case.contact
    if not (isinstance(contact, Section) and "stiffness" in type(contact).model_fields):
        kind = getattr(contact, "kind", type(contact).__name__)
        allowed = "contact.kind = 'penalty', 'ngsolve'"
        raise CaseError(f"contact.kind = '{kind}' has no penalty to verify; allowed: {allowed}")


def stiffer_result(
    case: AnyCase | BodyScene,
    additions: Additions,
    last: StepReport,
    raised: float = 1.0,
    *,
    end: float | None = None,
) -> Table:
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
    stiffer = _with(case, contact=contact)
    scene = stiffer if _remembers(case, additions) else _at_last_level(stiffer)
    *_, step = additions.simulation(scene, Clock(end)).accepted_steps()
    table = {name: _compared(getattr(last.record, name), getattr(step.record, name), "stiffer") for name in _COMPARED}
    table["penetration_over_wall"] = _compared(_overlap(last), _overlap(step.report), "stiffer")
    return {"stiffness_factor": STIFFER, **table}


def finer_result(
    case: AnyCase | BodyScene, additions: Additions, last: StepRecord, *, end: float | None = None
) -> Table:
    """Return what the last step of a case becomes on a finer mesh: on the finest one, taken on from where it ended,
    beside the errors that were told (`finest_result`); by one order more, where none were (`order_more_result`)."""
    if not_estimated(case):
        return order_more_result(case, additions, last, end=end)
    return finest_result(case, additions, end=end)


def finest_result(case: AnyCase | BodyScene, additions: Additions, *, end: float | None = None) -> Table:
    """Return what the last step of a case becomes on the finest mesh, to which it goes on from where it ended.

    For the parameters, and what it raises, see `stiffer_result`; errors of the case are estimated.

    Returns
    -------
    dict
        Order and unknowns of the finest mesh and, for each number, the value as it was, on the finest mesh, the
        difference over the former (``None`` where that is zero), and the error that was told, in its unit. Gaps are
        those of walls that are held where the step ended. Levels of a tissue that do not depend on each other are left
        out. Where no finer mesh finds an equilibrium, `failed` says so.
    """
    scene = _with(case) if _remembers(case, additions) else _at_last_level(_with(case))
    simulation = additions.simulation(scene, Clock(end))
    *_, accepted = simulation.follow(simulation.start)
    reported = simulation.refinement.refine(accepted)
    finest = simulation.refinement.taken_on(reported, stages_of(scene, finest=True))
    if finest is None:
        return {"failed": "no finer mesh finds an equilibrium, or there is none"}
    here, there = step_numbers(reported), step_numbers(finest)
    there = there.over_walls_of(here)
    table: Table = {}
    for name in _OF_MESH:
        pair = getattr(here, name), getattr(there, name)
        table[name] = _compared(*pair, "finer") | {"error": getattr(reported.errors, name)}
    forces = hypot(*here.plate_force), hypot(*there.plate_force)
    table["plate_force"] = _compared(*forces, "finer") | {"error": reported.errors.plate_force}
    mesh = simulation.refinement.table()[finest.level]
    return {"order": mesh["order"], "unknowns": mesh["unknowns"], **table}


def order_more_result(
    case: AnyCase | BodyScene, additions: Additions, last: StepRecord, *, end: float | None = None
) -> Table:
    """Return what a case becomes with elements of one order more, and the errors that follow.

    What a higher order lets remain of the error of the strongest singularity is known, and the numbers of the two
    meshes differ by all else: the coarser one errs by the difference over ``1 - remains`` (Babuska and Suri, SIAM Rev.
    36, 1994, doi:10.1137/1036141).

    Parameters
    ----------
    case : Case, BodyCase or BodyScene
        The case, whose errors are not estimated.
    additions : Additions
        What a script adds to it.
    last : StepRecord
        Its last accepted step.
    end : float, optional
        When that has to end, as `time.monotonic` tells it [s].

    Returns
    -------
    dict
        The order and, for each number, the value as it was, on the finer mesh, the difference over the former (``None``
        where that is zero), and the error of the former, in its unit. Where a step depends on those before it, all
        levels are run, and else the last one.

    Raises
    ------
    StepFailed
        If the finer problem finds no equilibrium.
    OutOfTime
        If it takes too long.
    """
    (kept,) = stages_of(case)
    finer = one_order_more(kept)
    scene = _with(finer.scene)
    if not _remembers(case, additions):
        scene = _at_last_level(scene)
    simulation = additions.simulation(scene, Clock(end))
    *_, step = simulation.accepted_steps()
    changed = 1 - finer.refining(kept, singular_exponent(simulation.space)).remains
    table: Table = {}
    for name in (*_OF_MESH, *(_OF_BONDS if case.cohesion is not None else ())):
        meant, other = getattr(last, name), getattr(step.record, name)
        table[name] = _compared(meant, other, "finer") | {"error": abs(other - meant) / changed}
    forces = [(record.plate_force_x, record.plate_force_y, record.plate_force_z) for record in (last, step.record)]
    off = hypot(*(two - one for one, two in zip(*forces, strict=True)))
    table["plate_force"] = _compared(hypot(*forces[0]), hypot(*forces[1]), "finer") | {"error": off / changed}
    table["parted_pairs"] = _compared(last.parted_pairs, step.record.parted_pairs, "finer")
    return {"order": finer.order, **table}


def _with(case: AnyCase | BodyScene, **changed: Any) -> AnyCase | BodyScene:
    """Return a case with other entries, which is not expected to have its numbers."""
    if isinstance(case, BodyScene):
        return replace(case, **changed) if changed else case
    return case.model_copy(update={"expected": (), **changed})


def _at_last_level(case: AnyCase | BodyScene) -> AnyCase | BodyScene:
    """Return a tissue with its last level alone; user-defined bodies follow all of theirs, and so does a load of a
    script, which need not know how to leave levels out."""
    if not isinstance(case, Case) or not isinstance(case.load, Section):
        return case
    load = case.load.model_copy(update={"levels": (case.level_factors[-1],)})
    return case.model_copy(update={"load": load})


def _remembers(case: AnyCase | BodyScene, additions: Additions) -> bool:
    """Return whether a step depends on those before it."""
    follows = additions.strategy is not None or getattr(getattr(case, "strategy", None), "kind", "") == "load-stepping"
    return follows or case.cohesion is not None


def _overlap(step: StepReport) -> float:
    checks = step.certificate.checks
    return next(check.value for check in checks if check.name == "penetration_over_wall")


def _compared(meant: float, other: float, word: str) -> Table:
    return {"meant": meant, word: other, "change": (other - meant) / abs(meant) if meant else None}

