"""What a result says first: certified or not, how sure its numbers are, and what came apart.

The words are made from what `summary.json` holds, finished or not, for the terminal and for the report of a run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from typing import Any

Summary = Mapping[str, Any]

#: Numbers of the last step that are told with their errors.
_TOLD = ("energy", "mean_gap", "largest_gap", "plate_force", "contact_force")
_GAPS = ("mean_gap", "largest_gap")
#: What to do where a check fails, by its name.
ADVICE = {
    "residual": "refine the mesh (mesh.size), or ask for smaller load steps (load.levels)",
    "penetration_over_wall": "raise contact.stiffness, or refine the mesh (mesh.size)",
    "body_balance": "ask for a smaller accuracy or for more levels (load.levels)",
    "plate_balance": "ask for a smaller accuracy or for more levels (load.levels)",
    "quadrature_error": "raise mesh.order or refine the mesh (mesh.size)",
    "stabilisation": "ask for a smaller accuracy or for more levels (load.levels)",
    "work_mismatch": "ask for more levels (load.levels)",
    "lowest_curvature": "the state is a saddle: ask for more levels, or run members (--members 10)",
    "smallest_jacobian": "elements are inverted: refine the mesh where the message says, or lower the load",
    "self_penetration_over_wall": "a body folds over itself: lower the load or thicken the wall",
    "energy_above_tied": "the walls found a worse state than the tied one: ask for more levels (load.levels)",
    "tension": "raise contact.stiffness, or refine the mesh (mesh.size)",
    "complementarity": "raise contact.stiffness, or refine the mesh (mesh.size)",
    "estimated_error": "ask for a larger accuracy, leave mesh.order and mesh.size out, round corners of cells "
    "(tissue.corner_radius), or use more memory",
    "energy_balance": "ask for more levels (load.levels)",
}


@dataclass(frozen=True)
class FailedCheck:
    """A check that some step failed: its name, worst value, limit, where, and what to try."""

    name: str
    worst: float | None
    limit: float | None
    place: str
    advice: str


def is_finished(summary: Summary) -> bool:
    """Return whether the run has ended by itself."""
    return summary.get("status") != "stopped" and summary.get("status") != "running"


def headline(summary: Summary) -> str:
    """Return in one line whether a result is certified, and why or why not."""
    steps = summary.get("accepted_steps") or 0
    if not is_finished(summary):
        reason = summary.get("reason")
        return f"not certified: the run {_stop_words(summary, reason)} after {_count(steps, 'accepted step')}"
    checks = len(_table(summary.get("certificate")))
    if summary.get("certified"):
        passed = f"; {_count(checks, 'check')} passed at each of {_count(steps, 'accepted step')}" if checks else ""
        return f"certified: converged{passed}"
    failed = len(summary.get("failed_steps") or ())
    outcome = str(summary.get("outcome") or "no outcome is known")
    if failed:
        how = "converged, but " if outcome.startswith("converged") else ""
        words = f"not certified: {how}{failed} of {_count(steps, 'accepted step')} failed a check"
        return words if how else f"{words}; {outcome}"
    return f"not certified: {outcome}"


def _table(found: object) -> Mapping[str, Any]:
    """Return a table of a summary; an empty one where a damaged summary has something else."""
    return found if isinstance(found, Mapping) else {}


def _stop_words(summary: Summary, reason: object) -> str:
    if summary.get("status") == "running":
        return "has not ended, or was killed,"
    return f"was stopped ({reason})" if reason else "was stopped"


def checks_not_passed(summary: Summary) -> list[FailedCheck]:
    """Return the checks that failed, each with what to try."""
    return [
        FailedCheck(name, check.get("worst"), check.get("limit"), check.get("place", ""), ADVICE.get(name, ""))
        for name, check in _table(summary.get("certificate")).items()
        if isinstance(check, Mapping) and check.get("passed") is False
    ]


def error_remark(summary: Summary) -> str:
    """Return why no errors, or no numbers, are told of the last step; empty where they are."""
    if summary.get("nothing_strained"):
        return "no wall is strained; energy and forces are zero"
    reason = summary.get("error_not_estimated")
    if reason and "order" in (summary.get("finer_mesh") or {}):
        return ""
    if reason:
        return f"errors not estimated: {reason}"
    last = summary.get("last_step") or {}
    known = last.get("energy_error")
    return "" if known is not None and isfinite(known) else "the error of the last step could not be estimated"


def slid_remark(summary: Summary) -> str:
    """Return how far walls have slid to where they rest, where the mean gap changed by more than it errs."""
    last = summary.get("last_step") or {}
    gap, error, slid = (last.get(name) or 0.0 for name in ("mean_gap", "mean_gap_error", "mean_gap_slid"))
    if not slid > error or not gap or summary.get("nothing_strained"):
        return ""
    share = f"{100 * slid / abs(gap):.2g} %"
    return f"the mean gap changed by {share} as walls slid to rest; other places of rest may be as far from it"


def how_estimated(summary: Summary) -> str:
    """Return in words where the errors of the last step are from."""
    order = (summary.get("finer_mesh") or {}).get("order") if summary.get("error_not_estimated") else None
    return "with estimated errors" if order is None else f"with errors that elements of order {order} tell"


def last_load(summary: Summary) -> str:
    """Return in words at which load the last accepted step is; empty where there is none."""
    last = summary.get("last_step") or {}
    if not last:
        return ""
    moved = f"plate displacement {last['plate_displacement']:.4g}, " if last.get("plate_displacement") else ""
    return f"{moved}load factor {last['load_factor']:.4g}{', walls still tied' if _is_tied(summary) else ''}"


def _is_tied(summary: Summary) -> bool:
    return (summary.get("last_step") or {}).get("phase") == "tied"


def last_numbers(summary: Summary) -> dict[str, tuple[float, float | None]]:
    """Return numbers of the last step, each with its estimated error or None; the plate force is the size of it.

    Walls that are still tied have neither gaps nor contact forces; where nothing is strained there are only gaps.
    """
    last, finer = summary.get("last_step") or {}, summary.get("finer_mesh") or {}
    sizes = {"plate_force": hypot(*(last.get(f"plate_force_{axis}") or 0.0 for axis in "xyz"))} if last else {}
    found = {}
    for name in _names(summary):
        row = finer.get(name) or {"error": last.get(f"{name}_error")}
        value, error = sizes.get(name, last.get(name)), row["error"]
        if value is not None:
            found[name] = (value, error if error is not None and isfinite(error) else None)
    return found


def _names(summary: Summary) -> list[str]:
    """Return the names of the numbers that mean something at the last step."""
    last = summary.get("last_step") or {}
    if _is_tied(summary):
        return [name for name in _TOLD if name not in (*_GAPS, "contact_force")]
    if summary.get("nothing_strained"):
        return [name for name in _GAPS if abs(last.get(name) or 0.0) > 1e-9 * (last.get("plate_displacement") or 1.0)]
    return list(_TOLD)


def with_error(value: float, error: float | None) -> str:
    """Return a number and its estimated error: relative, where that says something."""
    if error is None or not isfinite(error):
        return f"{value:.4g}"
    if abs(value) > error:
        share = 100 * error / abs(value)
        return f"{value:.4g} ± {share:.0f} %" if share >= 9.5 else f"{value:.4g} ± {share:.1g} %"
    return f"{value:.4g} ± {error:.1g}"


def came_apart(summary: Summary) -> str:
    """Return in one line what has come apart at the last level; empty where that is not known."""
    found, pairs = summary.get("debonding") or {}, summary.get("facing_pairs")
    if not found or not pairs:
        return ""
    opened, parted = found.get("wall_pairs_opened", 0), found.get("wall_pairs_parted", 0)
    sizes: Sequence[int] = found.get("component_sizes") or ()
    words = [f"{opened} of {_count(pairs, 'wall pair')} opened and {parted} parted"]
    if len(sizes) > 1:
        words.append(f"{_count(sum(sizes), 'cell')} in {len(sizes)} connected components")
    free = summary.get("held_by_nothing") or ()
    if free:
        words.append(f"{_count(len(free), 'cell')} held by nothing")
    return "; ".join([*words, *_onset(summary)])


def _onset(summary: Summary) -> Iterator[str]:
    onset, last = summary.get("onset_of_growth"), summary.get("last_step") or {}
    # Of a load that is taken back, the last step does not tell which of the two it moves along.
    if onset is not None and (last.get("plate_displacement") or last.get("load_factor")):
        bound = "no later than " if summary.get("onset_is_a_bound") else ""
        yield f"gaps grow from {bound}{_axis(last)} {onset:.3g}"


def _axis(step: Mapping[str, Any]) -> str:
    return "plate displacement" if step.get("plate_displacement") else "load factor"


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"
