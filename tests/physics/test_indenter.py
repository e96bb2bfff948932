"""A rigid indenter in a tissue: force, work and energy, and the cells in its way."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import inf
from typing import Any

import numpy as np
import pytest
import shapely
from matplotlib.colors import to_rgb
from matplotlib.image import imread

from ngcell import Case, CaseError, Indenter, read_case, record, simulate
from ngcell.build.discretisation import discretise
from ngcell.build.reported import Step
from ngcell.contact.surface.find import find_surface
from ngcell.export import draw_tissue
from ngcell.geometry.bodies import INDENTER, LEFT_SIDE, LOWER_PLATE, RIGHT_SIDE
from ngcell.run import draw_layout

WALL = 0.15
BRICKS = {"kind": "brick", "rows": 2, "cols": 2, "aspect": 2.0, "wall": WALL}
MATERIAL = {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0}
SHAPES: dict[str, dict[str, Any]] = {
    "flat": {"shape": "flat", "width": 1.5, "place": 2.6},
    "disc": {"shape": "disc", "radius": 1.0},
    "wedge": {"shape": "wedge", "width": 1.0, "angle": 80.0},
}
DEPTH, CLEARANCE = 0.15, WALL / 10
#: Up to the full depth, and back to the middle of the last two.
NEAR_FULL = [0.96, 1.0, 0.98]


def case(load: dict[str, Any], **parts: Any) -> Case:
    given = {"tissue": BRICKS, "material": MATERIAL, "strategy": {"kind": "single-step"}, "mesh": {"order": 2}}
    given = {**given, "accuracy": inf, **parts}
    # Between free sides frictionless bricks slide out of the indenter's way.
    given["load"] = {"kind": "indenter", "depth": DEPTH, "levels": 2, "sides": "confined", **load}
    return Case.model_validate(given)


@cache
def steps_of(scene: Case) -> list[Step]:
    return simulate(scene)


def followed(load: dict[str, Any], **parts: Any) -> list[Step]:
    steps = steps_of(case(load, **parts))
    assert all(step.record.certified and step.record.phase == "released" for step in steps)
    return steps


def pressed_full(shape: str) -> Step:
    (step,) = (
        step for step in followed({**SHAPES[shape], "levels": NEAR_FULL}) if step.record.load_factor == 1.0
    )
    return step


@pytest.mark.parametrize("shape", ["disc", "wedge"])
def test_the_work_of_the_indenter_is_the_energy(shape):
    steps = {step.record.load_factor: step.record for step in followed({**SHAPES[shape], "levels": NEAR_FULL})}
    before, full, middle = steps[0.96], steps[1.0], steps[0.98]
    assert full.plate_displacement == pytest.approx(DEPTH + CLEARANCE)
    assert full.energy > before.energy > 0 > middle.plate_force_y
    slope = (full.energy - before.energy) / (0.04 * full.plate_displacement)
    assert slope == pytest.approx(-middle.plate_force_y, rel=2e-3)


@pytest.mark.parametrize("radius", [0.05, 1.0, 30.0])
def test_a_disc_is_round(radius):
    space = discretise(case({"shape": "disc", "radius": radius})).space
    walls = find_surface(replace(space.bodies, wall_names=INDENTER), space.scalar, space.rest)
    places = (walls.basis.values(np.linspace(0, 1, 7)) @ walls.rest).reshape(-1, 2)
    lowest = places[places[:, 1].argmin()]
    near = places[np.abs(places[:, 0] - lowest[0]) < 0.25 * radius]
    near = near[near[:, 1] < lowest[1] + 0.04 * radius]
    away = np.linalg.norm(near - lowest - [0.0, radius], axis=1)
    assert np.abs(away / radius - 1).max() < 2e-4
    at = walls.rest[:, 0]
    is_low = (np.abs(at[:, 0] - lowest[0]) < 0.25 * radius) & (at[:, 1] < lowest[1] + 0.04 * radius)
    assert np.abs(walls.exterior_angle[is_low, 0]).max() < 0.02


@pytest.mark.parametrize("sides", ["free", "confined"])
def test_plate_and_sides_bear_what_the_indenter_presses_with(sides):
    """Between free sides nothing would hold cells that lie on others."""
    load = {**SHAPES["disc"], "depth": 0.05, "sides": sides, "levels": 1}
    tissue = BRICKS if sides == "confined" else {**BRICKS, "rows": 1}
    *_, step = followed(load, tissue=tissue)
    built, reaction = discretise(case(load, tissue=tissue)), step.measurement.reaction
    pressed = built.motion.resultant(reaction, INDENTER)
    total = (reaction.reshape(2, -1) * built.space.one).sum(1)
    np.testing.assert_allclose(total, 0, atol=1e-6 * abs(pressed[1]))
    assert step.record.plate_force_y == pytest.approx(pressed[1])
    assert built.motion.resultant(reaction, LOWER_PLATE)[1] == pytest.approx(-pressed[1], rel=1e-5)
    pushed = [built.motion.resultant(reaction, side)[0] for side in (LEFT_SIDE, RIGHT_SIDE)]
    assert pushed[0] >= 0 >= pushed[1] if sides == "confined" else pushed == [0, 0]


def test_the_indenter_is_rigid_stores_nothing_and_is_no_cell():
    step = pressed_full("wedge")
    space = discretise(case(SHAPES["wedge"])).space
    own = (space.body_of_unknown == space.bodies.cell_count) & (space.one > 0)
    moved = step.displacement.reshape(2, -1)[:, own]
    np.testing.assert_allclose(moved, np.broadcast_to([[0], [-DEPTH - CLEARANCE]], moved.shape), atol=1e-14)
    assert len(step.cells) == space.bodies.cell_count == 4
    assert all(max(wall.cell_a, wall.cell_b) < 4 for wall in step.walls)


@pytest.mark.parametrize("shape", SHAPES)
def test_cells_are_not_in_the_way_of_the_indenter(shape):
    """The outlines of all bodies at the end, straight between vertices, overlap by what contact gives in."""
    step = pressed_full(shape)
    space = discretise(case(SHAPES[shape])).space
    at = (space.rest + step.displacement.reshape(2, -1))[:, : space.mesh.nv].T
    parts: list[list[shapely.Polygon]] = [[] for _ in range(space.body_count)]
    for element, body in zip(space.mesh.Elements(), space.bodies.body_of_element, strict=True):
        parts[body].append(shapely.Polygon(at[[vertex.nr for vertex in element.vertices]]))
    *cells, indenter = (shapely.union_all(elements) for elements in parts)
    assert indenter.bounds[1] == pytest.approx(2.0 - DEPTH)
    assert sum(cell.intersection(indenter).area for cell in cells) < 0.01 * DEPTH


@pytest.mark.parametrize(
    "lumen",
    [{"kind": "pressure", "pressure": 0.002}, {"kind": "inclusion", "material": MATERIAL}, {"kind": "fluid"}],
    ids=lambda lumen: lumen["kind"],
)
def test_filled_cells_resist_more(lumen):
    load, row = {**SHAPES["disc"], "depth": 0.05, "levels": 1}, {**BRICKS, "rows": 1}
    hollow, filled = followed(load, tissue=row)[-1], followed(load, tissue=row, lumen=lumen)[-1]
    assert filled.record.plate_force_y < hollow.record.plate_force_y < 0
    assert all(cell.pressure > 0 for cell in filled.cells)


def test_hollow_cells_return_with_the_indenter():
    there, _, back = (step.record for step in followed({**SHAPES["disc"], "levels": [0.5, 1.0, 0.5]}))
    assert back.energy == pytest.approx(there.energy, rel=1e-4)


@pytest.mark.parametrize(
    ("entries", "says"),
    [({"depth": 2.0}, "is through the tissue; allowed: below 2"), ({"place": -1.0}, "allowed: from 0 to 5")],
)
def test_an_indenter_that_misses_or_goes_through_is_refused(entries, says):
    with pytest.raises(CaseError, match=says):
        simulate(case({**SHAPES["flat"], **entries}))


def test_only_single_steps_follow_an_indenter(tmp_path):
    with pytest.raises(CaseError, match="is sddp, which cannot follow this load; allowed: single-step"):
        case(SHAPES["flat"], strategy={"kind": "sddp"})
    file = tmp_path / "flat.toml"
    text = 'tissue = { rows = 1, cols = 1, wall = 0.1 }\nmaterial = { kind = "mooney-rivlin", c1 = 1.0, c2 = 1.0'
    text += ', bulk_modulus = 9.0 }\nload = { kind = "indenter", shape = "flat", width = 1.0, depth = 0.1 }\n'
    file.write_text(text)
    with pytest.raises(CaseError, match=r"flat.toml: strategy.kind: is sddp, .* allowed: single-step"):
        read_case(file)


def test_a_script_makes_the_load_of_a_case_file():
    given = Indenter(depth=DEPTH, levels=2, sides="confined", **SHAPES["disc"])
    assert given == case(SHAPES["disc"]).load


def test_prisms_are_refused():
    with pytest.raises(CaseError, match="is for planar cells; allowed: a tissue without height"):
        case(SHAPES["flat"], tissue={**BRICKS, "height": 1.0})


def test_the_indenter_is_drawn_and_recorded_beside_the_cells(tmp_path):
    breakable = {**MATERIAL, "strength": 100.0}
    scene = case({**SHAPES["wedge"], "levels": 1}, observables=[{"kind": "rotation"}], material=breakable)
    assert draw_layout(scene, tmp_path / "layout.png").stat().st_size > 10_000
    list(record(scene, tmp_path / "run", threads=1))
    rows = (tmp_path / "run" / "cells.csv").read_text().splitlines()
    assert len(rows) == 1 + 4
    assert all((tmp_path / "run" / name).is_file() for name in ("tissue.png", "debonding.png"))


def test_the_indenter_is_filled_as_rigid_and_nothing_seems_to_hold_the_upper_side(tmp_path, monkeypatch):
    from matplotlib.axes import Axes

    words: list[str] = []
    monkeypatch.setattr(Axes, "text", lambda self, x, y, said, **_: words.append(said))
    scene = case({**SHAPES["wedge"], "levels": NEAR_FULL})
    layout = imread(draw_layout(scene, tmp_path / "layout.png"))
    assert words == ["0", "1", "2", "3", "rigid"]
    words.clear()
    *_, last = steps_of(scene)
    assert set(np.unique(last.snapshot.bulk.cell_data["rigid"])) == {0, 1}
    tissue = imread(draw_tissue(last.snapshot, tmp_path / "tissue.png", title="", certified=True))
    assert words.count("rigid") == 1
    for picture in (layout, tissue):
        grey = np.abs(picture[..., :3] - to_rgb("#aab0b8")).max(2) < 0.02
        assert grey.mean() > 0.02


@pytest.mark.parametrize(
    "load",
    [
        {"shape": "disc", "radius": 1e6},
        {"shape": "wedge", "width": 1.0, "angle": 1e-3},
        {"shape": "flat", "width": 1e6},
    ],
    ids=["disc", "wedge", "flat"],
)
def test_of_an_indenter_far_larger_than_the_tissue_only_what_may_touch_is_meshed(load):
    bodies = discretise(case(load)).space.bodies
    usual = discretise(case(SHAPES["disc"])).space.bodies
    assert bodies.mesh.ne < 3 * usual.mesh.ne
    mesh, is_indenter = bodies.mesh, bodies.body_of_element >= bodies.cell_count
    vertices = [[vertex.nr for vertex in element.vertices] for element in mesh.Elements()]
    mine = np.unique(np.concatenate([vertices[number] for number in np.flatnonzero(is_indenter)]))
    nodes = np.array([vertex.point for vertex in mesh.vertices])
    indenter, cells = nodes[mine], np.delete(nodes, mine, axis=0)
    low = cells[:, 1].max() + CLEARANCE
    assert indenter[:, 1].min() == pytest.approx(low, rel=1e-9)
    assert np.ptp(indenter[:, 0]) < 5 * np.ptp(cells[:, 0])
    if "radius" in load:
        lowest = indenter[indenter[:, 1] < low + CLEARANCE]
        rise = (lowest[:, 0] - (cells[:, 0].min() + cells[:, 0].max()) / 2) ** 2 / (2 * load["radius"])
        np.testing.assert_allclose(lowest[:, 1], low + rise, rtol=0, atol=1e-9)
