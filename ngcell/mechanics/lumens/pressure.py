"""Cell pressure: cells under the same pressure share a boundary region and one load."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Strict

from ngcell.geometry.tissues.protocol import Lumens, TissueGeometry
from ngcell.mechanics.applied.boundary_pressure import Pressure
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.lumens.lumen import CLOSED
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Term
from ngcell.scene.scope import are_open_prisms, refuse
from ngcell.scene.section import NonNegativeNumber, Section

Array = NDArray[np.float64]
Row = Annotated[tuple[NonNegativeNumber, ...], Strict(False)]


class CellPressure(Section):
    """A pressure in every cell, which acts on its wall as it deforms.

    Parameters
    ----------
    pressure : float or tuple of tuple of float, shape (rows, cols)
        Pressure at load factor 1, a stress, >= 0: the same in all cells, or that of each, the lowest row first; the
        rows of further layers of prisms follow.
    ramp : {"with-load", "first"}
        Whether it grows in proportion to the load, or is there in full at every level.
    """

    kind: Literal["pressure"] = "pressure"
    pressure: NonNegativeNumber | Annotated[tuple[Row, ...], Strict(False)]
    ramp: Literal["with-load", "first"] = "with-load"

    @property
    def before_load(self) -> str | None:
        """What is there in full before the load, in words; None where it grows with the load."""
        return "a lumen.pressure that comes first" if self.ramp == "first" else None

    @property
    def needs_held_ends(self) -> bool:
        """Whether the rims of open prisms must be held along their axis: where they move freely, the pressure on the
        wall beside them has no potential."""
        rows = self.pressure if isinstance(self.pressure, tuple) else ((self.pressure,),)
        return any(value > 0 for row in rows for value in row)

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse hollow layers, and another number of pressures than there are cells."""
        tissue = scene.get("tissue")
        if tissue is None:
            return
        if are_open_prisms(scene) and tissue.layers > 1:
            refuse(f"escapes between layers of hollow prisms; {CLOSED}", "kind")
        rows, cols = tissue.grid
        if isinstance(self.pressure, tuple) and [len(row) for row in self.pressure] != [cols] * rows:
            allowed = "allowed: one pressure, or {rows} rows of {cols}, as many as there are cells"
            refuse(allowed, "pressure", rows=rows, cols=cols)

    @property
    def solid(self) -> None:
        """No solid fills the lumens."""
        return None

    def of_cells(self, tissue: TissueGeometry) -> Array:
        """Return the pressure in each cell at load factor 1 [stress], shape (cells,)."""
        given = np.asarray(self.pressure, dtype=float)
        return np.array(np.broadcast_to(given, tissue.grid if given.ndim else (tissue.cell_count,))).ravel()

    def regions(self, tissue: TissueGeometry) -> Lumens:
        """Return the cells whose inner walls form each region: those under the same pressure."""
        values, group = np.unique(self.of_cells(tissue), return_inverse=True)
        return {f"lumen{number}": np.flatnonzero(group == number) for number in range(len(values))}

    def terms(
        self, space: DisplacementSpace, motion: PrescribedMotion, tissue: TissueGeometry, wall: HyperelasticLaw
    ) -> tuple[Term, ...]:
        """Return the pressures on all regions as one term."""
        given = self.of_cells(tissue)
        pressures = ((name, float(given[cells[0]])) for name, cells in self.regions(tissue).items())
        loads = [Pressure(boundary=name, value=value) for name, value in pressures if value > 0]
        return (AppliedLoads(space, loads, motion, in_full=self.ramp == "first", cell_pressure=given),)
