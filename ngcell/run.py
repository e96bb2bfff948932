"""The front door for scripts and for the command line: run a scene, record a case, look at one before solving it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from ngcell import export
from ngcell.build.additions import Additions, told_additions
from ngcell.build.discretisation import discretise
from ngcell.build.memory import entry_count, foreseen_memory, is_filled, solver_name
from ngcell.build.options import Options
from ngcell.build.problems import OwnTerm
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.build.stages import stages_of
from ngcell.contact.pairing.facing import count_corners
from ngcell.errors import CaseError, NotConverged, OutputError
from ngcell.export import accepted_steps, cannot_resume, read_restart, read_summary, restore_case
from ngcell.export.atomic import replace_file
from ngcell.geometry.bodies import FRAME, INDENTER, LEFT_SIDE, LOWER_PLATE, RIGHT_SIDE, UPPER_PLATE
from ngcell.geometry.statistics import tissue_table
from ngcell.mechanics.loading.load import with_bodies_of
from ngcell.recording import Recording, RecordingOptions, file_told, recorded_text
from ngcell.results.layout import layout_of
from ngcell.results.observables.observable import Observable
from ngcell.scene import AnyCase, BodyScene, Case, read_case
from ngcell.scene.written_bodies import is_from_python
from ngcell.solve.step import StepFailed
from ngcell.solve.strategies.strategy import Strategy
from ngcell.threads import threads as on_threads
from ngcell.threads import threads_for


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
    CaseError
        If the scene cannot be built; `GeometryError` and `TooLarge` are kinds of it.
    NotConverged
        If a step finds no equilibrium; the error holds the steps that were accepted before.
    """
    simulation = Additions(terms, observables, strategy, options).simulation(scene)
    steps: list[Step] = []
    try:
        with on_threads(threads_for(None)):
            for step in simulation.accepted_steps():
                steps.append(step)
    except StepFailed as failure:
        message = f"at load factor {failure.load_factor:.6g}: {failure.outcome.value}"
        raise NotConverged(message, outcome=failure.outcome.name, steps=tuple(steps)) from failure
    return steps


def record(
    case: AnyCase | BodyScene,
    out: Path,
    *,
    terms: Sequence[OwnTerm] = (),
    observables: Sequence[Observable] = (),
    strategy: Strategy | None = None,
    options: Options | None = None,
    threads: int | None = None,
    verify_penalty: bool = False,
    verify_mesh: bool = False,
    force: bool = False,
    max_minutes: float | None = None,
    pictures: bool = True,
) -> Recording:
    """Return a run of a case, or of a scene from Python, into a result folder; iterate over it to run it.

    Each step is on disk when it is yielded; afterwards `certified`, `outcome` and `summary` tell how the run ended.
    Where the folder holds accepted steps of an earlier run, it is refused unless `force` is given; they are then
    replaced when this run accepts its first step. For `terms` to `options` see `simulate`, for the others
    `ngcell.recording.RecordingOptions`.

    Raises
    ------
    CaseError
        At once, if there is nothing to verify; while iterating, if the scene cannot be meshed.
    NotConverged
        While iterating: a step found no equilibrium, or the time is over. What was accepted before is on disk.
    OutputError
        While iterating: the folder holds another run, or cannot be written.
    """
    how = RecordingOptions(threads, verify_penalty, verify_mesh, force, max_minutes, pictures)
    return Recording(case, out, additions=Additions(terms, observables, strategy, options), options=how)


def resume(
    out: Path,
    *,
    scene: BodyScene | None = None,
    terms: Sequence[OwnTerm] = (),
    observables: Sequence[Observable] = (),
    strategy: Strategy | None = None,
    options: Options | None = None,
    threads: int | None = None,
    verify_penalty: bool = False,
    verify_mesh: bool = False,
    max_minutes: float | None = None,
    pictures: bool = True,
) -> Recording:
    """Return the rest of a run that stopped; iterate over it to run it.

    Its steps up to the stop are kept, and it ends with the numbers that it would have had without the stop.

    Parameters
    ----------
    out : Path
        Its result folder.
    scene : BodyScene, optional
        The scene of a run that was made from Python, which no file holds in full.
    terms, observables, strategy, options
        What the run was given by a script, as for `simulate`; no file holds it.
    threads, verify_penalty, verify_mesh, max_minutes, pictures
        As for `record`.

    Raises
    ------
    OutputError
        If the folder holds no run, or one that has ended, or is damaged, or is of another scene or other additions.
    """
    out = Path(out)
    additions = Additions(terms, observables, strategy, options)
    how = RecordingOptions(
        threads, verify_penalty, verify_mesh, max_minutes=max_minutes, pictures=pictures
    )
    summary = read_summary(out)
    if summary.get("status") == "finished":
        raise OutputError(f"{out} needs no resuming: the run has ended ({summary.get('outcome')})")
    count = accepted_steps(out, summary)
    restore_case(out, summary)
    case = scene or _recorded_case(out)
    _check_additions(out, additions)
    if not count:
        return Recording(case, out, additions=additions, options=how)
    restart = read_restart(out)
    if file_told(case) not in restart.case_text:
        raise cannot_resume(out, f"{case.tissue.file} is not what it was when the run began")  # type: ignore[union-attr]
    if restart.case_text != recorded_text(case, additions):
        what = "case.toml is not the case of this run any more" if scene is None else "it was made from another scene"
        raise cannot_resume(out, what)
    return Recording(case, out, additions=additions, options=how, restart=restart)


def _check_additions(out: Path, additions: Additions) -> None:
    """Check that what a script adds is what it added before the stop, as far as objects tell what they are."""
    file = out / "case.toml"
    told = told_additions(file.read_text(encoding="utf-8", errors="replace")) if file.is_file() else ""
    if told != additions.told:
        before, now = (", ".join(text.splitlines()) or "nothing" for text in (told, additions.told))
        raise OutputError(
            f"cannot resume {out}: its script had added {before}; now it adds {now}; "
            f'hand over the same again: ngcell.resume("{out}", ...)'
        )


def _recorded_case(out: Path) -> AnyCase:
    """Return the case of a result folder."""
    file = out / "case.toml"
    if file.is_file() and is_from_python(file.read_text(encoding="utf-8", errors="replace")):
        raise OutputError(
            f"cannot resume {out} without its scene, which was made from Python; "
            f'hand it over again: ngcell.resume("{out}", scene=...)'
        )
    try:
        return read_case(file)
    except CaseError as error:
        raise cannot_resume(out, str(error)) from error


def inspect(case: AnyCase | BodyScene, *, options: Options | None = None) -> dict[str, Any]:
    """Build a case without solving it, and return what would be solved; raise `CaseError` if it cannot be built.

    These are counts, areas, thicknesses and neighbours of cells, meshes and memory [GiB] that are foreseen, the largest
    gap and overlap at rest [length], the smallest and largest penalty stiffness [stress/length], and the levels.
    """
    simulation = Simulation(case, options=options)
    facing, walls = simulation.setup.facing, simulation.walls
    gap = facing.gaps(walls, walls.rest)
    finer = simulation.refinement.expected()
    minimiser = finer.released.minimisers[-1]
    entries, solver = entry_count(finer.problem), solver_name(minimiser)
    memory = foreseen_memory(entries, finer.space.dimension, solver, is_filled=is_filled(finer.problem))
    return {
        **_tissue(case),
        "bodies": simulation.bodies.body_count,
        "elements": int(simulation.bodies.mesh.ne),
        "order": simulation.space.order,
        "unknowns": simulation.space.unknowns,
        "free_unknowns": int(simulation.problem.free.sum()),
        "accuracy": simulation.accuracy if simulation.refinement.estimates else None,
        "error_not_estimated": simulation.not_estimated or None,
        "meshes_foreseen": simulation.refinement.table(),
        "wall_edges": walls.facet_count,
        "facing_pairs": len(simulation.setup.facing.pairs),
        "three_cell_corners": count_corners(walls),
        "largest_initial_gap": float(gap.max(initial=0.0)),
        "largest_initial_overlap": float(max(0.0, -gap.min(initial=0.0))),
        "penalty_stiffness": _extremes(getattr(simulation.contact, "stiffness", None)),
        "levels": list(case.level_factors),
        "matrix_entries": entries,
        "solver": solver,
        "memory_foreseen_gib": round(memory, 2),
    }


def draw_layout(case: AnyCase | BodyScene, path: Path) -> Path:
    """Draw what would be solved: cells with their numbers, elements, walls and supports; return `path`.

    Prisms are seen along their axes.

    Raises
    ------
    GeometryError
        If the scene is of solids.
    OutputError
        If the file cannot be written.
    """
    meshed: Any = stages_of(case)[0].scene
    if isinstance(meshed, Case) and isinstance(meshed.tissue, BaseModel):
        flat = {"height": None, "end_wall": None, "layers": 1}
        flat = {name: value for name, value in flat.items() if name in type(meshed.tissue).model_fields}
        tissue: Any = meshed.tissue.model_copy(update=flat)
        load = meshed.load
        bodies = with_bodies_of(load, tissue.mesh(load.supported, meshed.mesh))
        above = INDENTER if bodies.rigid_count else UPPER_PLATE  # below an indenter nothing holds the upper side
        supports = [] if load.supported is None else [LOWER_PLATE, above, LEFT_SIDE, RIGHT_SIDE, FRAME]
    else:
        found = discretise(meshed)
        bodies, supports = found.space.bodies, [support.region for support in found.motion.supports]
    return export.draw_layout(layout_of(bodies, supports), path, title=getattr(case, "title", ""))


def export_febio(case: AnyCase, path: Path) -> dict[str, Any]:
    """Write a planar tissue as a FEBio 4 deck, and return what is in it.

    Raises
    ------
    CaseError
        If the deck cannot say what the case says.
    OutputError
        If the file cannot be written.
    """
    from ngcell.build.febio.deck import deck_of  # only here: it knows fluids and fibres, which few scenes load
    from ngcell.build.febio.scope import SILENT
    from ngcell.build.febio.xml import deck_text

    deck = deck_of(case)
    replace_file(path, deck_text(deck).encode())
    return {
        "deck": str(path),
        "nodes": len(deck.layer.nodes),
        "elements": len(deck.layer.elements),
        "thickness": deck.layer.thickness,
        "pairs": len(deck.pairs),
        "steps": "tied, released" if deck.is_tied_first else "pressed",
        "not exported": list(SILENT),
    }


def _tissue(case: AnyCase | BodyScene) -> dict[str, Any]:
    """Return the numbers of a tissue whose cells have outlines; nothing of other scenes."""
    tissue = getattr(case, "tissue", None)
    outlines = getattr(tissue, "outlines", None)
    if tissue is None or outlines is None:
        return {}
    _, collapsed = getattr(tissue, "plan", (outlines, 0))
    return {"tissue": tissue_table(outlines, tissue.walls, collapsed)}


def _extremes(values: Any) -> list[float] | None:
    return None if values is None or not np.size(values) else [float(np.min(values)), float(np.max(values))]
