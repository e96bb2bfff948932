"""The tissues of the study of kinds, and what it makes of runs that end early or part."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from ngcell import Case
from tests.prisms import MATERIAL
from tools.runs import Ended
from tools.studies.kinds import FAILED, UNFINISHED, differences, found, is_wanted
from tools.studies.kinds_of_tissue import SMALL, TISSUES, WALL, labels, polygons


def test_polygons_tile_but_for_their_pores_and_half_of_them_are_re_entrant():
    cells = [shapely.Polygon(corners) for corners in polygons(5, 4)]
    union = shapely.union_all(cells)
    assert sum(cell.area for cell in cells) == pytest.approx(union.area, rel=1e-12)
    assert len(union.interiors) == 6
    assert sum(cell.convex_hull.area > cell.area + 0.1 for cell in cells) == 10


def test_the_image_has_one_pore_and_a_label_for_each_cell():
    image = labels(5, 4)
    assert np.unique(image).tolist() == list(range(21))
    row, col = np.nonzero(image == 0)
    inside = (slice(row.min() - 1, row.max() + 2), slice(col.min() - 1, col.max() + 2))
    assert len(np.unique(image[inside])) - 1 >= 3  # it is where three cells meet


@pytest.mark.parametrize("tissues", [TISSUES, SMALL], ids=["full", "small"])
def test_all_tissues_can_be_built(tissues, tmp_path):
    counts = {}
    for name, entries in tissues.items():
        table = {"wall": WALL, **entries(tmp_path)}
        load = {"kind": "plates", "stretch": 1.2, "levels": 1}
        case = Case.model_validate({"tissue": table, "material": MATERIAL, "load": load})
        counts[name] = case.tissue.outlines.cell_count
    assert [*counts.values()] == ([60, 60, 35, 20, 20] if tissues is TISSUES else [12, 12, 9, 9, 9])


def test_runs_that_end_early_are_rows_with_the_reason():
    late = Ended(4, 1.0, 1.0, 1.0, False, "", "mesh 1: x\nbeyond load factor 0: (--max-minutes); resume")
    assert found(late, {"status": "stopped"})["outcome"] == UNFINISHED
    failed = found(Ended(3, 1.0, 1.0, 1.0, False, "", "tissue.wall = 1: closes its lumen; allowed"), {})
    assert failed["outcome"] == FAILED and failed["reason"] == "tissue.wall = 1: closes its lumen"
    last = {"phase": "released", "load_factor": 0.1}
    part = {"status": "finished", "last_step": last, "outcome": "no equilibrium; try"}
    assert found(Ended(4, 1.0, 1.0, 1.0, False, "", ""), part)["reason"] == "no equilibrium after load factor 0.1"


def test_a_run_is_made_again_if_it_had_less_time_only():
    row = {"outcome": UNFINISHED, "minutes": "3"}
    assert is_wanted(None, 1) and is_wanted(row, 4) and not is_wanted(row, 3)
    assert not is_wanted(row | {"outcome": "certified"}, 4)


def test_strategies_are_compared_where_both_have_an_energy():
    names = ("size", "tissue", "corners", "held", "load", "cells_are")
    key = dict(zip(names, "abcdef", strict=True)) | {"outcome": "certified"}
    rows = [key | {"strategy": name, "energy": value} for name, value in (("sddp", "1.0"), ("single-step", "1.001"))]
    (line,) = differences(rows)
    assert line[8] == "1.0e-03" and line[9] == "different equilibria, or errors of the mesh; 2 of 2 certified"
    assert not list(differences([*rows[:1], rows[1] | {"energy": ""}]))
