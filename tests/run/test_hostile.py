"""The oracle of the hostile scenes finds what is wrong in written files, and nothing in those that are right."""

from __future__ import annotations

import numpy as np
import pytest

import ngcell
from tools.extreme.hostile_fields import Element, Fields, deepest_overlap, lumen_areas, read_levels, shapes
from tools.extreme.hostile_judge import examine
from tools.extreme.hostile_scenes import FAMILIES, Run, Scene, scenes

LAW = {"c1": 1.0, "c2": 0.5, "bulk_modulus": 20.0}


def squares(*corners: tuple[float, float], moved=lambda x: x) -> Fields:
    """Return unit squares with these lower left corners, a cell each."""
    element = Element(is_quad=True, width=2)
    rest = np.array([element.lattice + corner for corner in corners])
    return Fields(element, rest, moved(rest), np.arange(len(corners)))


def test_energy_and_jacobian_of_a_stretch_are_exact():
    fields = squares((0.0, 0.0), moved=lambda x: x * [1.2, 0.9])
    jacobian = 1.2 * 0.9
    first, second = 1.2**2 + 0.9**2 + 1, jacobian**2 + 1.2**2 + 0.9**2
    exact = 0.5 * (first * jacobian ** (-2 / 3) - 3) + 0.25 * (second * jacobian ** (-4 / 3) - 3)
    assert fields.energy(LAW) == pytest.approx(exact + 10 * np.log(jacobian) ** 2, rel=1e-12)
    assert fields.smallest_jacobian == pytest.approx(jacobian, rel=1e-12)


def test_overlaps_of_two_and_folds_of_one_are_seen():
    apart, over = shapes(squares((0, 0), (1, 0))), shapes(squares((0, 0), (0.9, 0)))
    assert deepest_overlap(apart) < 1e-12 and deepest_overlap(over) == pytest.approx(0.1 / 1.1 * 1.0, rel=1e-6)
    one = squares((0, 0), (0.5, 0))
    itself = Fields(one.element, one.rest, one.moved, np.zeros(2, dtype=np.int64))
    assert shapes(itself).self_overlap[0] == pytest.approx(0.5, rel=1e-9)


def test_a_run_that_is_right_has_no_finding_and_a_forged_energy_has_one(tmp_path):
    overrides = ["tissue.rows=1", "tissue.cols=2", "load.displacement=[0.2, 0.0]", "load.levels=1", "mesh.order=2"]
    scene = ngcell.read_case("shear-empty-3x3", [*overrides, "accuracy=inf"])
    for _ in ngcell.record(scene, tmp_path / "out"):
        pass
    case = scene.model_dump(exclude_none=True)
    drawn = Scene("one", "", Run(case))
    assert examine(drawn, tmp_path / "out").wrong == []
    ((_, fields),) = read_levels(tmp_path / "out")
    rest, now = lumen_areas(fields)[0]
    assert rest == pytest.approx(1.5 * np.sqrt(3) * (1 - 0.1 / (np.sqrt(3) / 2)) ** 2, rel=1e-9) and now < rest * 1.1
    table = tmp_path / "out" / "history.csv"
    lines = table.read_text().splitlines()
    names = lines[0].split(",")
    last = lines[-1].split(",")
    last[names.index("energy")] = "1.0"
    table.write_text("\n".join([*lines[:-1], ",".join(last)]))
    found = [text.split(":")[0] for text in examine(drawn, tmp_path / "out").wrong]
    assert found == ["energy", "above the tied energy"]


def test_scenes_are_a_hundred_and_fifty_and_the_same_each_time():
    one, two = scenes(), scenes()
    assert len(one) == 150 == sum(count for _, count, *_ in FAMILIES)
    assert one == two and len({scene.label for scene in one}) == 150
    assert scenes(7)[0].run.case != one[0].run.case
