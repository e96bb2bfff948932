"""Kinds of tissue under the loads of the references: which runs are certified, what fails in others.

    python -m tools.studies kinds [--small] [--corners sharp] [--held frame] [--strategy single-step] [--minutes 3]

Five tissues (Voronoi cells, bricks, a noisy honeycomb, polygons with pores and re-entrant cells, a label image with a
pore) are sheared, stretched and compressed by a fifth; their cells are hollow, under pressure, filled, or hollow with
bonds between walls: 60 runs at the default accuracy. Corners of outer walls are sharp, or rounded by a radius of the
wall's thickness, so that spaces are left between three cells, as in parenchyma. Plates hold the lower and upper edge,
or a frame all outer walls: then nothing reports a force. Bonds are followed by load stepping, whatever the strategy;
their errors are not estimated. `--small` has tissues of a dozen cells, of which all runs take an hour or two.

A row a run goes to `tools/results/kinds.csv`, those without a result included; runs that are there are not repeated,
but for those that ran out of a shorter time. Result folders are kept in `out/kinds`. `tools/results/kinds.md` shows
rows, and by how much the energies of both strategies differ, with how many of the two are certified; `--show` writes it
and runs nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import click
import numpy as np
import tomli_w

import ngcell
from tools import tables
from tools.commands import described
from tools.places import RESULTS, ROOT
from tools.runs import Ended, ended, solve_words, sources, summary_in
from tools.studies.kinds_of_tissue import SMALL, TISSUES, WALL

TABLE, SHOWN = RESULTS / "kinds.csv", RESULTS / "kinds.md"
FOLDERS = ROOT / "out" / "kinds"
KEYS = ("size", "tissue", "corners", "held", "load", "cells_are", "strategy")
COLUMNS = (
    *KEYS, "outcome", "reason", "energy", "energy_error", "plate_force", "plate_force_error", "mean_gap",
    "mean_gap_error", "cells", "loose", "unknowns", "meshes", "iterations", "seconds", "minutes", "code",
)  # fmt: skip
#: What a run ends as.
CERTIFIED, NOT_CERTIFIED, UNFINISHED, FAILED = "certified", "not certified", "out of time", "failed"
#: How much tissues are deformed, and how much longer than asked for a run may take before it is ended from outside.
SHARE, _PATIENCE = 0.2, 1.5
#: Levels of bonds, which are followed.
_LEVELS_OF_BONDS = 10
#: Energies of both strategies that differ by less, as a share, are one equilibrium.
_SAME = 1e-4
LOADS = ("sheared", "stretched", "compressed")
#: Radius of corners of 120° of outer walls [length].
CORNERS = {"rounded": WALL, "sharp": 0.0}
HELD = ("plates", "frame")
STRATEGIES = ("sddp", "single-step")
#: What cells are, as entries of a case: pressure, solid and bonds are as in the shipped cases of the sheared honeycomb.
CELLS: dict[str, dict[str, Any]] = {
    "hollow": {},
    "under pressure": {"lumen": {"kind": "pressure", "pressure": 0.005}},
    "filled": {
        "lumen": {
            "kind": "inclusion",
            "material": {"kind": "mooney-rivlin", "c1": 0.01, "c2": 0.0, "bulk_modulus": 10.0},
        }
    },
    "bonded": {"cohesion": {"strength": 0.05, "energy": 0.0015}, "strategy": {"kind": "load-stepping"}},
}

Key = tuple[str, str, str, str, str, str, str]


def load(held: str, name: str, height: float) -> dict[str, Any]:
    """Return a load of a tissue of this height [length], as entries of a case."""
    factor = {"stretched": 1 + SHARE, "compressed": 1 - SHARE}.get(name)
    if held == "plates":
        how = {"displacement": [SHARE * height, 0.0]} if factor is None else {"stretch": factor}
    else:
        how = {"shear": SHARE} if factor is None else {"stretch": [1.0, factor]}
    return {"kind": held, **how}


def case(key: Key, folder: Path) -> dict[str, Any]:
    """Return the case of a run, its files in a folder."""
    size, tissue, corners, held, name, cells, strategy = key
    shape = {"wall": WALL, "corner_radius": CORNERS[corners]}
    entries: dict[str, Any] = {
        "title": f"{tissue}, {cells}, {name}",
        "accuracy": 0.01,
        "tissue": {**shape, **(SMALL if size == "small" else TISSUES)[tissue](folder)},
        "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
        "load": {"kind": "plates", "stretch": 1.0, "levels": 1},
        "strategy": {"kind": strategy},
        **CELLS[cells],
    }
    height = float(np.ptp(ngcell.Case.model_validate(entries).tissue.outlines.corners[:, 1]))
    levels = _LEVELS_OF_BONDS if "cohesion" in entries else 1
    return entries | {"load": {"levels": levels, **load(held, name, height)}}


def measured(key: Key, minutes: float) -> dict[str, object]:
    """Run once, and return the row."""
    folder = FOLDERS / "-".join(part.replace(" ", "-") for part in key)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "scene.toml"
    row: dict[str, object] = {**dict(zip(KEYS, key, strict=True)), "minutes": f"{minutes:g}", "code": sources()}
    try:
        file.write_text(tomli_w.dumps(case(key, folder)), encoding="utf-8")
    except ngcell.CaseError as error:
        return row | {"outcome": FAILED, "reason": str(error)}
    words = [*solve_words(str(file), folder / "result"), "--max-minutes", f"{minutes:g}", "--verbose"]
    run = ended(*words, timeout=_PATIENCE * 60 * minutes)
    (folder / "log").write_text(run.err, encoding="utf-8")
    return row | found(run, summary_in(folder / "result"))


def found(run: Ended, summary: Mapping[str, Any]) -> dict[str, object]:
    """Return what a run has found: its outcome, and numbers of its last level where it got there."""
    ran: dict[str, object] = {"seconds": f"{run.clock:.0f}"}
    if run.timed_out or summary.get("status") != "finished":
        words = "ended from outside" if run.timed_out else run.last_words("no words").partition(";")[0]
        return ran | {"outcome": UNFINISHED if run.is_late else FAILED, "reason": f"{words}{_got_to(run.err)}"}
    last = summary["last_step"]
    if not last or last["phase"] == "tied" or last["load_factor"] < 1:
        until = f" after load factor {last['load_factor']:.3g}" if last else ""
        words = f"{summary['outcome'].partition(';')[0]}{until}"
        return ran | {"outcome": FAILED, "reason": f"{words}{_got_to(run.err)}"}
    failed = sorted({name for names in summary["failed_steps"].values() for name in names})
    is_nothing = bool(summary["nothing_strained"])
    reason = ", ".join(failed) or ("walls have parted: nothing is strained" if is_nothing else "")
    return ran | {
        "outcome": CERTIFIED if summary["certified"] else NOT_CERTIFIED,
        "reason": reason,
        "energy": 0 if is_nothing else f"{last['energy']:.7g}",
        "energy_error": "" if is_nothing else _share(last["energy_error"], last["energy"]),
        "plate_force": 0 if is_nothing else _number(np.hypot(last["plate_force_x"], last["plate_force_y"])),
        "plate_force_error": "" if is_nothing else _share(
            last["plate_force_error"], np.hypot(last["plate_force_x"], last["plate_force_y"])
        ),
        "mean_gap": _number(last["mean_gap"]),
        "mean_gap_error": "" if is_nothing else _share(last["mean_gap_error"], last["mean_gap"]),
        "cells": summary["bodies"],
        "loose": len(summary["held_by_nothing"] or ()),
        "unknowns": summary["unknowns"],
        "meshes": len(summary["meshes"] or ()),
        "iterations": summary["iterations"],
    }  # fmt: skip


def _got_to(log: str) -> str:
    """Return what the log of a run without a result last said of a mesh."""
    lines = [line for line in log.splitlines() if "estimated error" in line]
    return f"; {lines[-1].partition(': ')[2]}" if lines else ""


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _share(error: float | None, value: float) -> str:
    return "" if error is None or not value else f"{error / abs(value):.1e}"


def shown(rows: Sequence[Mapping[str, str]]) -> str:
    """Return rows and the comparison of strategies in Markdown."""
    names = (
        *KEYS, "outcome", "energy", "energy_error", "plate_force", "plate_force_error", "mean_gap",
        "mean_gap_error", "loose", "meshes", "seconds", "reason",
    )  # fmt: skip
    words = [name.replace("_", " ") for name in names]
    listed = tables.markdown(words, ([row[name] for name in names] for row in rows))
    compared = tables.markdown(
        [*(name.replace("_", " ") for name in KEYS[:-1]), *STRATEGIES, "difference", "said"], differences(rows)
    )
    counted = ", ".join(f"{sum(row['outcome'] == each for row in rows)} {each}" for each in _outcomes(rows))
    return f"{len(rows)} runs: {counted}. Errors are relative.\n\n{listed}\n\n{compared}\n"


def _outcomes(rows: Iterable[Mapping[str, str]]) -> list[str]:
    return sorted({row["outcome"] for row in rows})


def differences(rows: Iterable[Mapping[str, str]]) -> Iterator[list[str]]:
    """Yield energies of scenes that both strategies have solved, and their difference as a share of the lower."""
    by_key = {tuple(row[name] for name in KEYS): row for row in rows if row["energy"]}
    for key in dict.fromkeys(key[:-1] for key in by_key):
        one, two = (by_key.get((*key, strategy)) for strategy in STRATEGIES)
        if one is None or two is None:
            continue
        energies = abs(float(one["energy"])), abs(float(two["energy"]))
        share = (max(energies) - min(energies)) / min(energies) if min(energies) else float(max(energies) > 0)
        said = "the same" if share <= _SAME else "different equilibria, or errors of the mesh"
        certified = sum(row["outcome"] == CERTIFIED for row in (one, two))
        yield [*key, one["energy"], two["energy"], f"{share:.1e}", f"{said}; {certified} of 2 certified"]


def is_wanted(row: Mapping[str, str] | None, minutes: float) -> bool:
    """Return whether a run with this row, if there is one, is to be made with so much time."""
    return row is None or (row["outcome"] == UNFINISHED and float(row["minutes"]) < minutes)


def chosen(options: Mapping[str, Any]) -> Iterator[Key]:
    """Yield the keys of all runs that are asked for; bonds are followed by one strategy only."""
    size = "small" if options["small"] else "full"
    every = product(options["tissue"] or TISSUES, options["load"] or LOADS, options["cells_are"] or CELLS)
    for tissue, name, cells in every:
        strategy = "load-stepping" if cells == "bonded" else options["strategy"]
        yield size, tissue, options["corners"], options["held"], name, cells, strategy


@described(__doc__)
@click.option("--small", is_flag=True, help="Tissues of a dozen cells.")
@click.option("--tissue", multiple=True, type=click.Choice([*TISSUES]), help="Only these.")
@click.option("--load", multiple=True, type=click.Choice(LOADS), help="Only these.")
@click.option("--cells", "cells_are", multiple=True, type=click.Choice([*CELLS]), help="Only these.")
@click.option("--corners", default="rounded", show_default=True, type=click.Choice([*CORNERS]))
@click.option("--held", default="plates", show_default=True, type=click.Choice(HELD))
@click.option("--strategy", default="sddp", show_default=True, type=click.Choice(STRATEGIES))
@click.option("--minutes", default=3.0, show_default=True, help="Longest time of a run.")
@click.option("--show", is_flag=True, help="Write the Markdown of the rows that are there, and run nothing.")
def command(minutes: float, show: bool, **options: Any) -> None:
    """Run what is missing, and show all rows."""
    for key in () if show else chosen(options):
        rows = {tuple(row[name] for name in KEYS): row for row in tables.read(TABLE)}
        if not is_wanted(rows.get(key), minutes):
            continue
        row = measured(key, minutes)
        tables.write(TABLE, COLUMNS, [*(kept for at, kept in rows.items() if at != key), row])
        told = (*KEYS, "outcome", "reason", "seconds")
        click.echo(", ".join(f"{name} {row[name]}" for name in told if row.get(name)))
    SHOWN.write_text(shown(tables.read(TABLE)), encoding="utf-8")
    click.echo(SHOWN)
