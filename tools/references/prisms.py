"""Prisms held along their axis, beside the planar cells that they are copies of.

    python -m tools.references prisms [--rows 3] [--cols 3]

A sheared tissue, empty, under pressure and filled: energy and plate force of the planar run, and by how much those of
the prisms for each height differ. A few minutes for the 3x3 tissue.
"""

from __future__ import annotations

from math import inf
from typing import Any

import click

import ngcell
from tools.commands import described

MATERIAL = {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0}
SOFT = {"kind": "mooney-rivlin", "c1": 0.05, "c2": 0.05, "bulk_modulus": 10.0}
LUMENS = {
    "empty": None,
    "under pressure": {"kind": "pressure", "pressure": 0.005},
    "filled": {"kind": "inclusion", "material": SOFT},
}
HEIGHT = 0.5


def sheared(rows: int, cols: int, lumen: Any, height: float | None) -> Any:
    """Shear a tissue by a plate displacement of 0.4 and return the last step; without a height it is planar."""
    prismatic = height is not None
    table = {
        "tissue": {"rows": rows, "cols": cols, "wall": 0.1, "height": height},
        "material": MATERIAL,
        "lumen": lumen,
        "load": {"kind": "plates", "displacement": (0.4, 0.0), "levels": 1, "ends": "held" if prismatic else None},
        "mesh": {"order": 2, "size": 0.5, "slices": 1 if prismatic else None},
        "accuracy": inf,
    }
    return ngcell.simulate(ngcell.Case.model_validate(table))[-1]


@described(__doc__)
@click.option("--rows", default=3, show_default=True)
@click.option("--cols", default=3, show_default=True)
def command(rows: int, cols: int) -> None:
    """Print energy and plate force of planar cells, and what prisms held along their axis differ by."""
    for name, lumen in LUMENS.items():
        planar, solid = (sheared(rows, cols, lumen, height) for height in (None, HEIGHT))
        both = "both certified" if planar.record.certified and solid.record.certified else "NOT CERTIFIED"
        parts = []
        for quantity in ("energy", "plate_force_x", "plate_force_y"):
            flat, deep = (getattr(step.record, quantity) for step in (planar, solid))
            parts.append(f"{quantity} {flat:.6g} ({deep / HEIGHT / flat - 1:+.1e})")
        click.echo(f"{name}: {', '.join(parts)}; {both}")
