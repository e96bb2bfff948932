"""Tissues of all kinds, from the case to the result: what `check` tells and draws, small loads that are certified."""

from __future__ import annotations

from math import inf
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.image import imread

from ngcell import Case, GeometryError, OutputError, inspect, read_case, record, resume, simulate
from ngcell.build.discretisation import discretise
from ngcell.build.simulation import Simulation
from ngcell.build.stages import stages_of
from ngcell.cli import ngcell
from ngcell.export.plan import places, wall_lines
from ngcell.run import draw_layout
from tests.prisms import MATERIAL

#: Two L shapes that interlock, and a rectangle on both.
CELLS = (
    [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
    [(2, 0), (3, 0), (3, 2), (1, 2), (1, 1), (2, 1)],
    [(0, 2), (3, 2), (3, 3), (0, 3)],
)
TABLE = "cell,x,y\n" + "".join(f"{number},{x},{y}\n" for number, cell in enumerate(CELLS) for x, y in cell)
KINDS: dict[str, dict[str, object]] = {
    "perturbed": {"rows": 3, "cols": 2, "spread": 0.15, "wall_spread": 0.2, "seed": 1},
    "brick": {"rows": 3, "cols": 2, "aspect": 2.0},
    "voronoi": {"cells": 6, "extent": [4.0, 4.0], "seed": 2},
    "polygons": {"file": "cells.csv"},
}


def case(kind: str, folder: Path, load: dict[str, object], **parts: object) -> Case:
    """Return a case of a kind, its files in a folder."""
    (folder / "cells.csv").write_text(TABLE)
    entries = KINDS[kind]
    if "file" in entries:
        entries = {"file": str(folder / "cells.csv")}
    return Case.model_validate(
        {
            "title": kind,
            "tissue": {"kind": kind, "wall": 0.1, **entries},
            "material": MATERIAL,
            "load": {"levels": 1, **load},
            "accuracy": inf,
            **parts,
        }
    )


PRESSED = {"kind": "plates", "stretch": 0.98}
SHEARED = {"kind": "frame", "shear": 0.02}


@pytest.mark.parametrize(
    ("kind", "load"), [("voronoi", PRESSED), ("polygons", PRESSED), ("perturbed", SHEARED), ("brick", SHEARED)]
)
def test_small_loads_are_certified(kind, load, tmp_path):
    # A corner of the Voronoi tissue is pressed into a wall by more than may be, without graded elements.
    accuracy = 0.1 if (kind, load) == ("voronoi", PRESSED) else inf
    tied, step = simulate(case(kind, tmp_path, load, accuracy=accuracy))
    assert step.record.certified, step.report
    assert 1e-9 < step.record.energy < (1 + 1e-6) * tied.record.energy


@pytest.mark.parametrize("kind", KINDS)
def test_the_tied_solid_has_no_gap(kind, tmp_path):
    tied = next(iter(Simulation(case(kind, tmp_path, {"kind": "frame", "stretch": [0.99, 0.99]})).accepted_steps()))
    assert tied.record.phase == "tied"
    assert abs(tied.record.largest_gap) < 1e-12


@pytest.mark.parametrize("kind", ["brick", "voronoi", "perturbed"])
def test_pressure_is_that_of_each_cell(kind, tmp_path):
    load = {"kind": "frame", "shear": 0.01}
    rows, cols = case(kind, tmp_path, load).tissue.grid
    pressures = (0.001 * (1 + np.arange(rows * cols) % 3)).reshape(rows, cols).tolist()
    lumen = {"kind": "pressure", "pressure": pressures}
    step = simulate(case(kind, tmp_path, load, lumen=lumen))[-1]
    assert step.record.certified
    assert step.record.energy != pytest.approx(simulate(case(kind, tmp_path, load))[-1].record.energy, rel=1e-3)


SOFT = {"kind": "inclusion", "material": {"kind": "mooney-rivlin", "c1": 0.05, "c2": 0.05, "bulk_modulus": 10.0}}


@pytest.mark.parametrize("kind", ["brick", "polygons"])
def test_filled_cells_are_certified_and_stiffer_than_hollow_ones(kind, tmp_path):
    """Bonded where cells are tied, the same frame deforms hollow and filled cells; what fills them stores more."""
    hollow, filled = (simulate(case(kind, tmp_path, SHEARED, lumen=lumen)) for lumen in (None, SOFT))
    assert filled[-1].record.certified, filled[-1].report
    assert filled[0].record.energy > 1.05 * hollow[0].record.energy


def test_where_lumens_are_meshed_anew_for_each_grading_there_is_one_grading(tmp_path):
    def gradings(kind: str, lumen: dict[str, object] | None) -> set[int]:
        scene = case(kind, tmp_path, SHEARED, lumen=lumen, accuracy=0.01)
        return {stage.grading for stage in stages_of(scene)}

    assert gradings("brick", SOFT) == {1}
    assert gradings("brick", None) == gradings("perturbed", SOFT) == {1, 2, 3}


def test_check_tells_cells_areas_walls_and_neighbours(tmp_path):
    told = inspect(case("polygons", tmp_path, {"kind": "plates", "stretch": 0.98}))["tissue"]
    assert told["cells"] == 3 and told["pores"] == 0 and told["collapsed_sides"] == 0
    assert told["walls_between_cells"] == 5 and told["outer_walls"] == 7
    assert told["cells_by_neighbours"] == {"2": 3}
    assert told["area"] == pytest.approx(
        {"mean": 3.0, "standard_deviation": 0.0, "smallest": 3.0, "largest": 3.0}, abs=1e-12
    )
    assert told["wall_thickness"]["standard_deviation"] == 0.0
    lumen = 3.0 - 8 * 0.1 + 4 * 0.01  # a rectangle of 3 x 1 and L shapes of the same perimeter and number of turns
    assert told["solid_share_of_area"]["mean"] == pytest.approx(1 - lumen / 3, rel=1e-9)
    assert inspect(read_case("shear-empty-3x3"))["tissue"]["cells_by_neighbours"] == {
        "2": 2, "3": 3, "4": 2, "5": 1, "6": 1
    }
    assert "tissue" not in inspect(read_case("press-fit"))


def colours(path: Path) -> set[tuple[int, ...]]:
    return {tuple(colour) for colour in (255 * imread(path)[..., :3]).round().astype(int).reshape(-1, 3)}


def test_check_draws_cells_walls_and_supports(tmp_path):
    file = tmp_path / "layout.png"
    words = ["check", "shear-empty-3x3", "--set", "tissue.kind=perturbed", "--set", "tissue.spread=0.1"]
    answer = CliRunner().invoke(ngcell, [*words, "--picture", str(file)])
    assert answer.exit_code == 0 and answer.stdout.splitlines()[-1] == str(file)
    lower, upper = (0xB3, 0x36, 0x1E), (0x1F, 0x5F, 0x8B)
    assert {lower, upper} <= colours(file)
    draw_layout(read_case("twist-closed-3d"), tmp_path / "ends.png")
    assert not {lower, upper} & colours(tmp_path / "ends.png")
    draw_layout(read_case("press-fit"), tmp_path / "bodies.png")
    assert lower in colours(tmp_path / "bodies.png")
    assert CliRunner().invoke(ngcell, [*words, "--picture", "layout.pdf"]).exit_code == 2


def test_solids_of_bodies_are_not_drawn(tmp_path):
    with pytest.raises(GeometryError, match="allowed: bodies in the plane, tissues"):
        draw_layout(solid_scene(), tmp_path / "a.png")


def solid_scene():
    from netgen import occ

    from ngcell import Body, BodyScene, BodySupport, MooneyRivlin

    law = MooneyRivlin(c1=1.0, c2=0.0, bulk_modulus=10.0)
    box = occ.Box(occ.Pnt(0, 0, 0), occ.Pnt(1, 1, 1))
    box.faces.Min(occ.Z).name = "foot"
    return BodyScene((Body(box, law, "box"),), (BodySupport("foot"),), levels=1)


@pytest.mark.parametrize("kind", ["perturbed", "brick", "polygons"])
def test_the_plan_of_walls_has_the_walls_that_cells_share(kind, tmp_path):
    scene = case(kind, tmp_path, {"kind": "plates", "stretch": 0.98})
    step = list(Simulation(scene).accepted_steps())[-1]
    cells, outlines = step.snapshot.bulk, scene.tissue.outlines
    shared = np.flatnonzero((outlines.twins >= 0) & (outlines.neighbours > outlines.cell))
    pairs = np.unique(np.column_stack([outlines.cell, outlines.neighbours])[shared], axis=0)
    assert len(places(cells)[0]) == outlines.cell_count
    for (one, two), lines in zip(pairs, wall_lines(cells, pairs), strict=True):
        mine = shared[(outlines.cell[shared] == one) & (outlines.neighbours[shared] == two)]
        length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()
        assert length == pytest.approx(outlines.lengths[mine].sum(), rel=1e-9)


def test_a_plate_has_no_wall_to_hold_is_found_before_anything_is_solved(tmp_path):
    (tmp_path / "tip.csv").write_text("cell,x,y\n0,0,0\n0,1,1\n0,0,2\n0,-1,1\n")
    table = {"kind": "polygons", "wall": 0.1, "file": str(tmp_path / "tip.csv"), "held_within": 0.2}
    load = {"kind": "plates", "stretch": 0.9, "levels": 1}
    scene = Case.model_validate({"tissue": table, "material": MATERIAL, "load": load})
    with pytest.raises(GeometryError, match="no outer wall lies whole within 0.2"):
        discretise(scene)


@pytest.mark.parametrize("is_changed", [False, True])
def test_a_run_is_resumed_with_the_file_that_it_began_with(is_changed, tmp_path):
    scene, out = case("polygons", tmp_path, {**SHEARED, "levels": 2}), tmp_path / "out"
    steps = iter(record(scene, out, pictures=False))
    next(steps)
    del steps
    if is_changed:
        (tmp_path / "cells.csv").write_text(TABLE.replace("3,3", "3,3.1"))
        with pytest.raises(OutputError, match=r"cells\.csv is not what it was when the run began"):
            resume(out)
    else:
        assert len(list(resume(out, pictures=False))) == 3
