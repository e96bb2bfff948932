"""Pressure patch test: a tissue held all around, with the same pressure in every cell.

    python -m tools.references confined [--rows 5] [--cols 7] [--pressure 0.01] [--ratio 1e4]

With incompressible walls nothing moves, and every wall bears that pressure, whatever its thickness. Shown are the
smallest and the largest contact pressure on all walls over the pressure in the cells, the largest displacement and the
gaps.
"""

from __future__ import annotations

from math import inf

import click
import numpy as np

import ngcell
from tools.commands import described
from tools.solutions import solved

#: Places on each edge at which pressures are compared.
PLACES = np.linspace(0.01, 0.99, 9)


@described(__doc__)
@click.option("--rows", default=5, show_default=True)
@click.option("--cols", default=7, show_default=True)
@click.option("--wall", default=0.1, show_default=True)
@click.option("--pressure", default=0.01, show_default=True, help="The shear modulus is 2.")
@click.option("--ratio", default=1e4, show_default=True, help="Bulk over shear modulus.")
@click.option("--contact", default="mortar", show_default=True)
def command(rows: int, cols: int, wall: float, pressure: float, ratio: float, contact: str) -> None:
    """Solve, and show what walls bear."""
    case = ngcell.Case.model_validate(
        {
            "tissue": {"rows": rows, "cols": cols, "wall": wall},
            "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 2 * ratio},
            "lumen": {"kind": "pressure", "pressure": pressure},
            "load": {"kind": "frame", "shear": 0.0, "levels": 1},
            "strategy": {"kind": "single-step"},
            "contact": {"kind": contact},
            "accuracy": inf,
        }
    )
    solution = solved(case)
    step, found = solution.last, solution.pressures_between_cells(PLACES) / pressure
    click.echo(
        f"{rows}x{cols} cells, pressure {pressure:g}: contact pressure over it {found.min():.6f} to {found.max():.6f}, "
        f"displacement {np.abs(step.displacement).max():.1e}, gaps {step.record.smallest_gap:.1e} to "
        f"{step.record.largest_gap:.1e}, {step.record.iterations} iterations, certified {step.record.certified}"
    )
