"""What is foreseen before meshing: too low rather than too high, and held against the memory that there is."""

from __future__ import annotations

import pytest
from netgen import occ

from ngcell.build import foreseen
from ngcell.errors import CaseError
from ngcell.run import inspect
from ngcell.scene import Body, BodyScene, MooneyRivlin, read_case

SOFT = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=10.0)


def two_boxes() -> BodyScene:
    boxes = [occ.Box(occ.Pnt(x, 0, 0), occ.Pnt(x + 1, 1, 1)) for x in (0, 2)]
    return BodyScene(tuple(Body(box, SOFT, f"box{i}") for i, box in enumerate(boxes)), (), size=0.3, order=2, levels=1)


SCENES = {
    "quadrilaterals": lambda: read_case("shear-empty-3x3", ["mesh.order=4"]),
    "filled": lambda: read_case("shear-filled", ["tissue.rows=1", "tissue.cols=2"]),
    "prisms": lambda: read_case("shear-empty-3d", ["tissue.rows=1", "tissue.cols=2"]),
    "triangles": lambda: read_case("stacked-blocks"),
    "refined": lambda: read_case("hertz-half-cylinder", ["mesh.order=1"]),
    "tetrahedra": two_boxes,
}


@pytest.mark.parametrize("name", SCENES)
def test_entries_are_foreseen_too_low_but_not_by_far(name, monkeypatch):
    seen: list[float] = []
    monkeypatch.setattr(foreseen, "foreseen_memory", lambda entries, dimension: seen.append(entries) or 0.0)
    entries = inspect(SCENES[name]())["matrix_entries"]
    assert 0.15 * entries < seen[-1] <= entries


def test_memory_that_is_there_is_that_of_the_group_of_processes(tmp_path, monkeypatch):
    whole = foreseen.available_memory()
    (tmp_path / "memory.max").write_text("max\n")
    monkeypatch.setattr(foreseen, "_CGROUP", tmp_path / "memory.max")
    assert foreseen.available_memory() >= whole > 0
    (tmp_path / "memory.max").write_text(f"{2**28}\n")
    assert foreseen.available_memory() == 0.25
    with pytest.raises(CaseError, match=r"GiB of memory; allowed: at most 0.25 GiB"):
        inspect(read_case("shear-empty-3x3"))


@pytest.mark.parametrize("number", [1e-300, 1e51, -1e60])
def test_numbers_without_room_to_calculate_are_refused(number):
    case = read_case("shear-empty-3x3", [f"load.displacement=[0.0, {number}]"])
    with pytest.raises(
        CaseError, match=r"^load\.displacement\[1\] = .*; allowed: 0, or a magnitude from 1e-50 to 1e\+50$"
    ):
        inspect(case)
