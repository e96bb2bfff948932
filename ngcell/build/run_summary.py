"""What the summary of a run says: how it ended, what was checked, and what it took."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ngcell.build.simulation import Simulation
from ngcell.results.certificate import worst
from ngcell.results.checks import scales_of
from ngcell.results.growth import growth_onset
from ngcell.results.record import StepRecord
from ngcell.results.report import StepReport
from ngcell.results.rupture.load import rupture_load

#: Strains of less than this share of what counts as hardly strained are round-off.
_ROUND_OFF = 1e-4


def run_summary(
    title: str, simulation: Simulation, steps: list[StepReport], outcome: str, certified: bool
) -> dict[str, Any]:
    """Return what `summary.json` holds of a run."""
    last = steps[-1] if steps else None
    checks = worst(step.certificate for step in steps)
    return {
        "title": title,
        "outcome": outcome,
        "certified": certified,
        "certificate": {
            name: {
                "worst": check.value,
                "limit": check.limit,
                "passed": check.passed,
                **({"place": check.place} if check.place else {}),
            }
            for name, check in checks.items()
        },
        "meaning_of_checks": {name: check.meaning for name, check in checks.items()},
        "expected": [finding.table() for step in steps for finding in step.findings],
        "failed_steps": {step.record.step: step.certificate.failures for step in steps if not step.record.certified},
        "accuracy": simulation.accuracy if simulation.refinement.estimates else None,
        "error_not_estimated": simulation.not_estimated,
        "meshes": max((simulation.refinement.table(), *(step.meshes for step in steps)), key=len),
        "accepted_steps": len(steps),
        "bodies": simulation.bodies.body_count,
        "unknowns": simulation.space.unknowns,
        "facing_pairs": len(simulation.setup.facing.pairs),
        "nothing_strained": last is not None and _is_round_off(simulation, last.record),
        "held_by_nothing": last.free_bodies if last else (),
        "changes_of_branch": {
            step.record.step: {"unstored_work": step.unstored_work}
            for step in steps
            if step.record.phase == "released" and step.unstored_work != 0
        },
        "debonding": next((step.debonding for step in reversed(steps) if step.debonding), {}),
        "onset_of_growth": onset_of_growth(simulation, steps),
        "onset_is_a_bound": _onset_is_a_bound(simulation, steps),
        **_rupture(simulation, steps),
        "iterations": sum(step.record.iterations for step in steps),
        "factorisations": sum(step.record.factorisations for step in steps),
        "refused": sum(step.refused for step in steps),
        "cut_backs": sum(step.cutbacks for step in steps),
        "last_step": asdict(last.record) if last else None,
    }


def _is_round_off(simulation: Simulation, last: StepRecord) -> bool:
    """Return whether nothing holds a tissue together any more, so that energy and forces are round-off."""
    setup = simulation.setup
    scales = scales_of(simulation.space, setup.modulus, 0.0)
    forces = (last.contact_force, last.plate_force_x, last.plate_force_y, last.plate_force_z)
    return (
        last.phase == "released"
        and abs(last.energy) < _ROUND_OFF**2 * scales.energy
        and all(abs(force) < _ROUND_OFF * scales.force for force in forces)
    )


def _rupture(simulation: Simulation, steps: list[StepReport]) -> dict[str, Any]:
    """Return the load at which the first wall would rupture, beside the load at which walls separate, and the work
    spent on both; nothing where it is not known what walls bear."""
    if simulation.setup.strength is None or not _released(steps):
        return {}
    records, last = _released(steps), _released(steps)[-1]
    debonding: dict[str, Any] = dict(next((step.debonding for step in reversed(steps) if step.debonding), {}))
    found = rupture_load(records, starts_at_rest=simulation.starts_at_rest)
    largest = max(records, key=lambda record: record.more["utilisation"])
    return {
        "rupture": {
            "load": None if found is None else asdict(found),
            "largest_utilisation": largest.more["utilisation"],
            "largest_utilisation_error": largest.more["utilisation_error"],
            "first_separation": debonding.get("first_separation"),
            "cells": debonding.get("cells", {}),
            "work_of_separation": last.separation_energy + last.dissipation,
            "work_of_rupture": debonding.get("burst_energy", 0.0),
        }
    }


def reached(steps: list[StepReport]) -> float:
    """Return the load factor that has been reached."""
    return steps[-1].record.load_factor if steps else 0.0


def _released(steps: list[StepReport]) -> list[StepRecord]:
    return [step.record for step in steps if step.record.phase == "released"]


def _onset_is_a_bound(simulation: Simulation, steps: list[StepReport]) -> bool:
    """Return whether gaps had grown at the first level already, and nobody knows how much earlier."""
    contact, onset = _released(steps), onset_of_growth(simulation, steps)
    starts_later = bool(contact) and contact[0].load_factor > 0 and not simulation.starts_at_rest
    return starts_later and onset == contact[0].place_on_path


def onset_of_growth(simulation: Simulation, steps: list[StepReport]) -> float | None:
    """Return the place on the load path at which gaps start to grow; None where they do not."""
    contact = _released(steps)
    place, mean = [row.place_on_path for row in contact], [row.mean_gap for row in contact]
    return growth_onset(place, mean, simulation.bodies.thickness, at_rest=simulation.mean_gap_at_rest)
