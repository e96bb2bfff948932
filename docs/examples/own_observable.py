"""An observable of one's own: the area of each cell, wall and lumen, which becomes a column and a field."""

import numpy as np
import pytest

from ngcell import Case, Frame, MeshChoice, MooneyRivlin, Tissue, simulate


class CellArea:
    name = "cell_area"

    def values(self, view):
        nodes, walls = view.nodes, view.walls  # of straight walls: half the sum of cross products of their ends
        start, end = (np.where(walls.side[:, None] > 0, nodes[:, at], nodes[:, -1 - at]) for at in (0, -1))
        twice = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
        return np.bincount(walls.body, twice) / 2


rubber, cells = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0), Tissue(rows=1, cols=1, wall=0.1)
load = Frame(stretch=(1.1, 1.2), levels=1)
case = Case(tissue=cells, material=rubber, load=load, mesh=MeshChoice(order=1))
*_, last = simulate(case, observables=[CellArea()])
assert last.record.more["cell_area"] == pytest.approx(1.5 * np.sqrt(3) * 1.1 * 1.2)  # the frame is the outline
assert last.snapshot.bulk.cell_data["cell_area"][0] == pytest.approx(last.record.more["cell_area"])
