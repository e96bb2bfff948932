"""Reading, overriding and writing back: a case says the same in every form."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pytest
from pydantic import ValidationError

from ngcell.errors import CaseError
from ngcell.results.record import StepRecord
from ngcell.scene import (
    Case,
    Expected,
    Frame,
    MooneyRivlin,
    Penalty,
    Plates,
    Sddp,
    SingleStep,
    Tissue,
    case_name,
    find_case,
    read_case,
    resolved_toml,
    schema,
    shipped_cases,
)

WriteCase = Callable[..., Path]
BODIES = [
    "closing-rings",
    "hertz-cylinders",
    "hertz-half-cylinder",
    "parting-rings",
    "press-fit",
    "press-fit-tight",
    "stacked-blocks",
]
TISSUES = [
    "bend-filled-3d",
    "bend-layers-3d",
    "crush-3x3",
    "crush-half",
    "frame-shear",
    "shear-empty",
    "shear-empty-3d",
    "shear-empty-3x3",
    "shear-empty-single-step",
    "shear-cohesive",
    "shear-fibres",
    "shear-filled",
    "shear-fluid",
    "shear-pressurised",
    "shear-uniform-pressure",
    "stretch-plates",
    "twist-closed-3d",
]
SHIPPED = sorted(BODIES + TISSUES)


def full_case() -> Case:
    """Return a case in which nothing is left to a default."""
    return Case(
        title='a "title" with\nlines',
        source="söurce",
        tissue=Tissue(rows=2, cols=3, side=1, wall=0.1, corner_radius=1e-5, orientation="flat"),
        material=MooneyRivlin(c1=1 / 3, c2=0, bulk_modulus=1e22),
        load=Frame(deformation_gradient=((1, 0.1), (0, 1)), levels=(0.1, 1 / 3, 1)),
        strategy=SingleStep(steps=7),
        contact=Penalty(stiffness=2.5),
        mesh={"order": 3, "size": 0.05, "layers": 2},
        expected=[Expected(level=1 / 3, quantity="energy", value=-1e-9, tolerance=1e-4, origin="second way")],
    )


def test_a_case_that_does_not_say_asks_for_an_accuracy_of_one_percent() -> None:
    material = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)
    said = Case(tissue=Tissue(rows=1, cols=2, wall=0.1), material=material, load=Plates(displacement=(0.1, 0.0)))
    assert said.accuracy == 0.01


def test_shipped_cases_are_found_by_name_and_by_path() -> None:
    files = shipped_cases()
    assert sorted(files) == SHIPPED
    for name, file in files.items():
        assert find_case(name) == file
        assert case_name(file) == name
        assert read_case(name) == read_case(file)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_cases_say_what_happens_and_where_it_comes_from(name: str) -> None:
    case = read_case(name)
    assert case.title
    assert ("SDDP" in case.source) if name in TISSUES else case.expected


def test_sheared_tissue_is_the_same_scene_for_both_strategies() -> None:
    by_parts, at_once = read_case("shear-empty"), read_case("shear-empty-single-step")
    assert by_parts.strategy == Sddp()
    assert at_once.strategy == SingleStep()
    scene = {"tissue", "material", "load", "contact", "mesh"}
    assert by_parts.model_dump(include=scene) == at_once.model_dump(include=scene)
    assert by_parts.tissue.cell_count == 35
    assert by_parts.load.level_factors == pytest.approx([0.125 * n for n in range(1, 9)])


@pytest.mark.parametrize("case", [full_case(), *map(read_case, SHIPPED)], ids=["full", *SHIPPED])
def test_resolved_case_reads_back_equal(case: Case, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(resolved_toml(case), encoding="utf-8")
    assert read_case(file) == case
    assert read_case(tmp_path) == case
    assert case_name(file) == tmp_path.name


def test_resolved_case_says_the_defaults(write_case: WriteCase) -> None:
    said = tomllib.loads(resolved_toml(read_case(write_case())))
    assert said["strategy"] == {"kind": "sddp"}
    assert said["contact"] == {"kind": "penalty", "stiffness": 1.0, "single_pass_corners": True}
    assert said["accuracy"] == 0.01
    assert said["mesh"] == {}  # order and grading follow from the accuracy
    assert said["tissue"]["orientation"] == "pointy"


def test_overrides_replace_and_add_values(write_case: WriteCase) -> None:
    overrides = [
        "tissue.wall=0.2",
        "tissue.orientation=flat",
        "load.levels=[0.25, 1]",
        "strategy.kind=single-step",
        "contact.stiffness=10",
        'title="a = b"',
        "mesh = { order = 3 }",
        "tissue.wall=0.3",
    ]
    case = read_case(write_case(), overrides)
    assert case.tissue == Tissue(rows=1, cols=2, wall=0.3, orientation="flat")
    assert case.load.level_factors == (0.25, 1.0)
    assert case.strategy == SingleStep()
    assert case.contact == Penalty(stiffness=10)
    assert case.title == "a = b"
    assert case.mesh.order == 3


def test_a_title_is_followed_by_what_was_set_beside_the_file(write_case: WriteCase) -> None:
    title = read_case(write_case()).title
    changed = read_case(write_case(), ["tissue.rows=3", "load.displacement=[0.2, 0.0]", "expected=[]"])
    assert changed.title == f"{title} (with tissue.rows = 3, load.displacement = [0.2, 0.0])"
    assert read_case(write_case(), ["load.levels=3", "load.levels=2"]).title == f"{title} (with load.levels = 2)"
    many = ", ".join(f"{0.01 * number:.2f}" for number in range(1, 21))
    assert read_case(write_case(), [f"load.levels=[{many}]"]).title == f"{title} (with another load.levels)"
    assert read_case(write_case(), ["tissue.rows=3", "title=Three rows"]).title == "Three rows"
    assert read_case(write_case(), ["expected=[]"]).title == title


def test_override_reaches_into_a_list(write_case: WriteCase) -> None:
    assert read_case(write_case(), ["load.displacement.0=0.3"]).load.displacement == (0.3, 0.0)


@pytest.mark.parametrize(
    ("override", "says"),
    [
        (
            "tissue.wall=thin",
            'bent.toml: --set: tissue.wall = "thin" is not possible; allowed: a finite',
        ),
        ("tissue.wall=nan", "bent.toml: --set: tissue.wall = NaN is not possible"),
        ("tissue.wal=0.2", "bent.toml: --set: tissue.wal = 0.2 is unknown; did you mean wall?"),
        ("tissue.rows=20000", "bent.toml:5: tissue.cols = 2: with rows = 20000"),
        ("tissue.wall.inner=1", "--set tissue.wall.inner=1: nothing to set inner in"),
        ("load.displacement.2=1", "--set load.displacement.2=1: nothing to set 2 in"),
        ("tissue..wall=1", "allowed: key=value with a dotted key"),
        ("tissue.wall", "allowed: key=value with a dotted key"),
        ("0=3", "--set: 0 = 3 is not possible; allowed: a table"),
        ("tissue.side=1" + 400 * "0", "tissue.side = "),
    ],
)
def test_wrong_override_is_one_line(write_case: WriteCase, override: str, says: str) -> None:
    with pytest.raises(CaseError) as caught:
        read_case(write_case(), [override])
    assert says in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_override_sets_one_key_only(write_case: WriteCase) -> None:
    assert read_case(write_case(), ["title=1\nrows = 3"]).title == "1\nrows = 3"


def test_levels_are_equal_or_as_listed() -> None:
    assert Plates(stretch=1.1, levels=4).level_factors == (0.25, 0.5, 0.75, 1.0)
    assert Plates(stretch=1.1, levels=[0.1, 0.7]).level_factors == (0.1, 0.7)
    assert Plates(stretch=1.1, levels=[1]).level_factors == (1.0,)


def test_steps_follow_the_levels_unless_the_strategy_says_more(write_case: WriteCase) -> None:
    assert read_case(write_case()).smallest_step_count == 2
    assert read_case(write_case(), ["strategy.steps=9"]).smallest_step_count == 9


@pytest.mark.parametrize(
    ("frame", "gradient"),
    [
        (Frame(shear=0.2), ((1, 0.2), (0, 1))),
        (Frame(stretch=(1.1, 0.9)), ((1.1, 0), (0, 0.9))),
        (Frame(deformation_gradient=[[1, 2], [3, 7]]), ((1, 2), (3, 7))),
    ],
)
def test_frame_ends_at_one_gradient_however_it_is_given(frame: Frame, gradient: object) -> None:
    assert frame.final_gradient == gradient


def test_a_case_does_not_change() -> None:
    case = full_case()
    with pytest.raises(ValidationError, match="frozen"):
        case.tissue.wall = 0.3  # type: ignore[misc]
    assert hash(case) == hash(full_case())


def test_schema_offers_each_kind_and_refuses_unknown_keys() -> None:
    offered = schema()["$defs"]["Case"]
    assert offered["required"] == ["tissue", "material", "load"]
    assert offered["additionalProperties"] is False
    assert set(offered["properties"]["load"]["discriminator"]["mapping"]) == {"plates", "frame", "ends", "indenter"}


def test_quantities_are_columns_of_the_history() -> None:
    columns = {field.name for field in fields(StepRecord)}
    assert set(schema()["$defs"]["Expected"]["properties"]["quantity"]["enum"]) <= columns


def test_folder_of_a_shipped_name_does_not_hide_the_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkdir("shear-empty")
    assert find_case("shear-empty") == shipped_cases()["shear-empty"]
