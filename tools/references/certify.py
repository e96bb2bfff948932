"""Certificates of the 5x7 tissue with all that may hold its cells together, by both strategies.

    python -m tools.references certify [--only TEXT] [--timeout 3000]

Each row of `tools/results/certified.csv` is a run of `ngcell solve` in a process of its own, with its last step and
the worst of the checks that decide; `certified.md` shows the rows. Runs that have a row are not repeated, runs that
were stopped go on. Levels are those of the curves, evenly spaced ones with cohesion; the others
are in `tools/sheared.py`.
"""

from __future__ import annotations

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import Run
from tools.sheared import BONDED, BOTH, SDDP, STRENGTHS, bonded, fibres, inclusions, large_run, pressures

TABLE, PAGE = RESULTS / "certified.csv", RESULTS / "certified.md"
KEYS = ("case", "settings", "strategy")
LAST = ("energy", "plate_force_x", "mean_gap", "parted_pairs")
CHECKS = ("residual", "penetration_over_wall", "complementarity", "body_balance", "plate_balance", "energy_balance")
COLUMNS = (
    *KEYS, "outcome", "certified", "failed_checks", "accepted_steps", *LAST, *CHECKS, "iterations", "factorisations",
    "processor_seconds",
)  # fmt: skip


def listed() -> list[tuple[str, str, tuple[str, ...]]]:
    """Return case, settings and strategies of all runs."""
    return [
        ("shear-empty", "", BOTH),
        *((case, setting, BOTH) for case, setting, _ in (*pressures(), *inclusions())),
        *(("shear-cohesive", bonded(value), BONDED) for value in STRENGTHS),
        ("shear-uniform-pressure", "", SDDP),
        ("shear-fluid", "", SDDP),
        *((case, setting, SDDP) for case, setting, _ in fibres()),
    ]


def row_of(run: Run, outcome: str) -> dict[str, object]:
    """Return what the run's folder says."""
    summary = run.summary
    last, checks = summary.get("last_step") or {}, summary.get("certificate") or {}
    failed = [name for name, check in checks.items() if not check["passed"]]
    return {
        "outcome": outcome,
        "certified": summary.get("certified", False),
        "failed_checks": " ".join(failed),
        "accepted_steps": summary.get("accepted_steps", 0),
        **{name: last.get(name, "") for name in LAST},
        **{name: f"{checks[name]['worst']:.1e}" if name in checks else "" for name in CHECKS},
        "iterations": summary.get("iterations", ""),
        "factorisations": summary.get("factorisations", ""),
        "processor_seconds": round(summary.get("seconds", {}).get("processor", 0)),
    }


def write_page() -> None:
    """Show the rows as a table."""
    columns = {
        "case": "case", "settings": "settings", "strategy": "strategy", "accepted_steps": "steps", "outcome": "outcome",
        "energy": "energy", "plate_force_x": "plate force", "mean_gap": "mean gap", "parted_pairs": "parted pairs",
        "penetration_over_wall": "overlap over wall", "energy_balance": "energy balance", "iterations": "iterations",
        "processor_seconds": "processor s",
    }  # fmt: skip
    numbers = {"energy", "plate_force_x", "mean_gap"}
    order = [(case, settings, strategy) for case, settings, both in listed() for strategy in both]
    rows = sorted(tables.read(TABLE), key=lambda row: order.index((row["case"], row["settings"], row["strategy"])))
    lines = [[f"{float(row[key]):.4g}" if key in numbers and row[key] else row[key] for key in columns] for row in rows]
    head = "# Certificates of the 5x7 tissue\n\n`python -m tools.references certify`; the last step of each run\n\n"
    PAGE.write_text(f"{head}{tables.markdown(list(columns.values()), lines)}\n", encoding="utf-8")


@described(__doc__)
@click.option("--only", default="", help="Runs whose case, settings or strategy contain this only.")
@click.option("--timeout", default=3000.0, show_default=True, help="Seconds after which a run is stopped.")
def command(only: str, timeout: float) -> None:
    """Run what has no row yet."""
    for case, settings, strategies in listed():
        for strategy in strategies:
            key = dict(zip(KEYS, (case, settings, strategy), strict=True))
            done = any(all(row[name] == value for name, value in key.items()) for row in tables.read(TABLE))
            if done or only not in " ".join(key.values()):
                continue
            run = large_run(case, settings, strategy)
            outcome = run.solve(timeout)
            row = key | row_of(run, outcome)
            click.echo(f"{case} {settings} {strategy}: {outcome} {row['failed_checks']}")
            if not outcome.startswith("stopped"):
                tables.append(TABLE, COLUMNS, [row])
                write_page()
    write_page()
