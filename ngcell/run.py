"""The front door for scripts and for the command line: run a scene, record a case, look at one before solving it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ngcell.build.memory import entry_count, foreseen_memory, solver_name
from ngcell.build.observation import Step
from ngcell.build.options import Options
from ngcell.build.simulation import OwnTerm, Simulation
from ngcell.contact.pairing.facing import count_corners
from ngcell.errors import CaseError, NotConverged, OutputError
from ngcell.export import accepted_steps, cannot_resume, read_restart, read_summary, restore_case
from ngcell.recording import Recording, use_threads
from ngcell.results.observables.observable import Observable
from ngcell.scene import AnyCase, BodyScene, read_case, resolved_toml
from ngcell.solve.step import StepFailed
from ngcell.solve.strategies.strategy import Strategy


def simulate(
    scene: AnyCase | BodyScene,
    *,
    terms: Sequence[OwnTerm] = (),
    observables: Sequence[Observable] = (),
    strategy: Strategy | None = None,
    options: Options | None = None,
) -> list[Step]:
    """Run a scene without writing anything, and return its accepted steps.

    Parameters
    ----------
    scene : Case, BodyCase or BodyScene
        What is simulated.
    terms : sequence of callable
        Further terms of the energy, each made from the displacement space.
    observables : sequence of Observable
        What is measured besides what every run measures.
    strategy : Strategy, optional
        How the load path is followed, in place of what the scene says.
    options : Options, optional
        The numbers of the solver and of contact.

    Raises
    ------
    NotConverged
        If a step finds no equilibrium; the error holds the steps that were accepted before.
    """
    simulation = Simulation(scene, terms=terms, observables=observables, strategy=strategy, options=options)
    steps: list[Step] = []
    try:
        with use_threads(None, simulation.space.unknowns):
            for step in simulation.accepted_steps():
                steps.append(step)
    except StepFailed as failure:
        message = f"at load factor {failure.load_factor:.6g}: {failure.outcome.value}"
        raise NotConverged(message, outcome=failure.outcome.name, steps=tuple(steps)) from failure
    return steps


def record(
    case: AnyCase,
    out: Path,
    *,
    threads: int | None = None,
    verify_penalty: bool = False,
    force: bool = False,
    max_minutes: float | None = None,
) -> Recording:
    """Return a run of a case into a result folder; iterate over it to run it.

    Where the folder holds accepted steps of an earlier run, it is refused unless `force` is given; they are then
    replaced when this run accepts its first step. For the other parameters see `Recording`.
    """
    return Recording(case, out, threads=threads, verify_penalty=verify_penalty, force=force, max_minutes=max_minutes)


def resume(
    out: Path, *, threads: int | None = None, verify_penalty: bool = False, max_minutes: float | None = None
) -> Recording:
    """Return the rest of a run that stopped; iterate over it to run it.

    Its steps up to the stop are kept, and it ends with the numbers that it would have had without the stop.

    Raises
    ------
    OutputError
        If the folder holds no run, or one that has ended, or is damaged.
    """
    how: dict[str, Any]
    out, how = Path(out), {"threads": threads, "verify_penalty": verify_penalty, "max_minutes": max_minutes}
    summary = read_summary(out)
    if summary.get("status") == "finished":
        raise OutputError(f"{out} needs no resuming: the run has ended ({summary.get('outcome')})")
    count = accepted_steps(out, summary)
    restore_case(out, summary)
    try:
        case = read_case(out / "case.toml")
    except CaseError as error:
        raise cannot_resume(out, str(error)) from error
    if not count:
        return Recording(case, out, **how)
    restart = read_restart(out)
    if restart.case_text != resolved_toml(case):
        raise cannot_resume(out, "case.toml is not the case of this run any more")
    return Recording(case, out, restart=restart, **how)


def inspect(case: AnyCase, *, options: Options | None = None) -> dict[str, Any]:
    """Build a case without solving it, and return what would be solved."""
    simulation = Simulation(case, options=options)
    facing, walls = simulation.setup.facing, simulation.walls
    gap = facing.gaps(walls, walls.rest)
    minimiser = simulation.released.minimisers[-1]
    entries, solver = entry_count(simulation.problem, minimiser), solver_name(minimiser)
    return {
        "bodies": simulation.bodies.body_count,
        "elements": int(simulation.bodies.mesh.ne),
        "order": simulation.space.order,
        "unknowns": simulation.space.unknowns,
        "free_unknowns": int(simulation.problem.free.sum()),
        "wall_edges": walls.facet_count,
        "facing_pairs": len(simulation.setup.facing.pairs),
        "three_cell_corners": count_corners(walls),
        "largest_initial_gap": float(gap.max(initial=0.0)),
        "largest_initial_overlap": float(max(0.0, -gap.min(initial=0.0))),
        "penalty_stiffness": _extremes(getattr(simulation.contact, "stiffness", None)),
        "levels": list(case.level_factors),
        "matrix_entries": entries,
        "solver": solver,
        "memory_foreseen_gib": round(foreseen_memory(entries, solver), 2),
    }


def _extremes(values: Any) -> list[float] | None:
    return None if values is None else [float(np.min(values)), float(np.max(values))]
