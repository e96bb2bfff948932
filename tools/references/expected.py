"""Run the cases that have expected numbers, and show what was measured beside them.

    python -m tools.references expected [CASE ...]       all shipped cases with expected numbers, or these

Ends with 1 where a run finds no equilibrium, fails a check of its certificate or misses an expected number.
"""

from __future__ import annotations

import sys
from time import perf_counter

import click
from rich.console import Console
from rich.table import Table

from ngcell import read_case, simulate
from ngcell.errors import NotConverged
from ngcell.scene import shipped_cases
from tools.commands import described


@described(__doc__)
@click.argument("names", nargs=-1, metavar="[CASE]...")
def command(names: tuple[str, ...]) -> None:
    """Run the cases that have expected numbers, and show what was measured beside them."""
    chosen = names or [name for name in shipped_cases() if read_case(name).expected]
    table = Table("case", "quantity", "on", "load", "measured", "expected", "deviation", "tolerance", "seconds")
    for column in table.columns[3:]:
        column.justify = "right"
    passed = [add_case(table, name) for name in chosen]
    Console(width=None if sys.stdout.isatty() else 160).print(table)
    sys.exit(not all(passed))


def add_case(table: Table, name: str) -> bool:
    """Run a case, add a row for each of its numbers, and return whether it is certified."""
    started = perf_counter()
    try:
        steps = simulate(read_case(name))
    except NotConverged as error:
        table.add_row(f"[red]{name}", f"[red]{error.outcome}", end_section=True)
        return False
    seconds = f"{perf_counter() - started:.1f}"
    findings = [finding for step in steps for finding in step.findings]
    failures = {check for step in steps for check in step.measurement.certificate.failures}
    for number, finding in enumerate(findings):
        table.add_row(
            name if number == 0 else "",
            finding.quantity,
            finding.place,
            f"{finding.load_factor:g}",
            f"{finding.measured:.6g}",
            f"{finding.expected:.6g}",
            f"[{'green' if finding.passed else 'red'}]{finding.deviation:+.1e}",
            f"{finding.tolerance:.0e}",
            seconds if number == 0 else "",
        )
    for check in sorted(failures):
        table.add_row("", f"[red]{check}", "certificate")
    table.add_section()
    return not failures and all(finding.passed for finding in findings)
