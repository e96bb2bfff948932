"""The load at which walls would rupture, how cells end, and what is reported of it."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import Any

import numpy as np
import pytest
from netgen import occ

from ngcell import read_case, record, simulate
from ngcell.errors import CaseError
from ngcell.results.error import Numbers, estimate
from ngcell.results.parts_of_error import Refining
from ngcell.results.record import StepRecord
from ngcell.results.rupture.cells import BURST, SEPARATED, WHOLE, CellEnds, at_rest, end_of
from ngcell.results.rupture.load import rupture_load
from ngcell.results.rupture.strength import COLUMNS
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin

SMALL = [
    "tissue.rows=2", "tissue.cols=2", "load.displacement=[0.4, 0.0]", "load.levels=2", "mesh.order=2", "accuracy=inf",
    "expected=[]",
]  # fmt: skip


def row(load: float, utilisation: float, error: float = 0.0, phase: str = "released") -> StepRecord:
    more = dict(zip(COLUMNS, (utilisation, error, 3.0, 1.0, 2.0), strict=True))
    numbers: list[Any] = [0, phase, load, load, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, True]
    return StepRecord(*numbers, more=more)


def test_a_line_is_met_exactly_and_errs_by_the_mesh_alone():
    found = rupture_load([row(0.25, 0.5, 0.02), row(0.5, 1.0 - 1e-12, 0.02), row(1.0, 2.0, 0.02)], starts_at_rest=True)
    assert found is not None
    assert found.load_factor == pytest.approx(0.5, rel=1e-9)
    assert found.error == pytest.approx(0.02 / 2, rel=1e-6)
    assert found.cell == 3 and found.place == (1.0, 2.0) and found.between == (0.5, 1.0)


def test_the_error_of_interpolation_holds_a_parabola():
    loads = np.array([0.2, 0.4, 0.6, 0.8, 1.0])
    found = rupture_load([row(x, 2.2 * x**2) for x in loads], starts_at_rest=True)
    assert found is not None
    exact = (1 / 2.2) ** 0.5
    assert 0 < abs(found.load_factor - exact) < 1.05 * found.interpolation_error < 0.01
    assert found.error == found.interpolation_error


def test_walls_that_had_ruptured_before_the_first_step_are_a_bound():
    found = rupture_load([row(0.3, 1.4), row(0.6, 2.0)], starts_at_rest=False)
    assert found is not None and found.load_factor == 0.3 and isnan(found.error) and found.between == (0.3, 0.3)
    told = rupture_load([row(0.3, 1.5)], starts_at_rest=True)
    assert told is not None and told.load_factor == pytest.approx(0.2) and told.interpolation_error == 0.15


def test_steps_whose_utilisation_is_not_known_are_left_out():
    known = [row(0.25, 0.5, 0.02), row(1.0, 2.0, 0.02)]
    found = rupture_load([known[0], row(0.4, float("nan"), float("nan")), known[1]], starts_at_rest=True)
    assert found == rupture_load(known, starts_at_rest=True) and found.load_factor == pytest.approx(0.5)


def test_nothing_is_told_where_nothing_ruptures_or_walls_are_tied():
    assert rupture_load([row(0.5, 0.9), row(1.0, 0.99)], starts_at_rest=True) is None
    assert rupture_load([row(0.5, 2.0, phase="tied"), row(0.5, 0.9)], starts_at_rest=True) is None


def test_a_cell_ends_by_what_comes_first():
    steps = at_rest(4)
    steps = steps.after(0.5, np.array([[0.5, 0.0, 0.2, 0.6], [0.0, 0.5, 0.0, 0.8]]), np.array([1.0, 2.0, 3.0, 4.0]))
    steps = steps.after(1.0, np.array([[2.0, 0.5, 0.4, 1.4], [1.1, 2.0, 0.9, 1.0]]), np.array([4.0, 2.0, 3.0, 6.0]))
    assert steps.ends == [BURST, SEPARATED, WHOLE, BURST]
    np.testing.assert_allclose(steps.loads, [[0.5 + 1 / 6, nan, nan, 0.75], [0.5 + 5 / 11, 0.5 + 1 / 6, nan, 1.0]])
    np.testing.assert_allclose(steps.burst_energy, [2.0, 0.0, 0.0, 5.0])
    later = steps.after(1.5, np.zeros((2, 4)), np.zeros(4))
    assert later.ends == steps.ends  # what has happened stays
    np.testing.assert_array_equal(later.burst_energy, steps.burst_energy)
    np.testing.assert_array_equal(CellEnds.from_array(later.array()).array(), later.array())


def test_ties_and_what_is_unknown():
    assert [end_of(0.5, 0.5), end_of(nan, 0.5)] == [SEPARATED, SEPARATED]
    assert [end_of(0.4, nan), end_of(nan, nan)] == [BURST, WHOLE]


def test_the_error_of_the_utilisation_is_told_and_not_judged():
    def numbers(utilisation: float) -> Numbers:
        return Numbers(1.0, 1.0, np.ones(2), 1.0, 1.0, 1.0, (1e-9, 1e-9, 1e-2), utilisation=utilisation)

    found = estimate([numbers(0.5), numbers(0.4)], [Refining(0.5)])
    assert found.utilisation == pytest.approx(0.1, rel=1e-12) and found.relative == 0


def test_nothing_is_added_where_nothing_is_said():
    plain, told = (simulate(read_case("shear-empty-3x3", [*SMALL, *more])) for more in ([], ["material.strength=0.01"]))
    assert plain[-1].record.more == {} and plain[-1].cells[0].more == {} and plain[-1].checkpoint.ends is None
    assert told[-1].record.energy == plain[-1].record.energy
    assert set(told[-1].cells[0].more) == {"utilisation", "burst_at", "separated_at", "burst_energy"}


def test_strength_does_not_act_on_the_solution_and_scales_the_utilisation():
    one, two = (simulate(read_case("shear-empty-3x3", [*SMALL, f"material.strength={s}"])) for s in (0.01, 0.04))
    assert one[-1].record.energy == two[-1].record.energy
    assert one[-1].record.more["utilisation"] == pytest.approx(4 * two[-1].record.more["utilisation"], rel=1e-12)


def test_an_even_stretch_is_met_exactly_by_both_measures():
    """A block whose whole outline follows an affine map; the length of averages is larger than the block or smaller."""
    gradient = np.array([[1.2, 0.1], [0.0, 0.9]])
    law = MooneyRivlin(c1=1.0, c2=0.5, bulk_modulus=10.0)
    solid = np.eye(3)
    solid[:2, :2] = gradient
    stress = np.linalg.eigvalsh(law.cauchy_stress(solid[None])[0])[-1]
    stretch = np.linalg.svd(gradient, compute_uv=False)[0]
    moved = BodySupport("side", gradient=tuple(map(tuple, (gradient - np.eye(2)).tolist())))  # type: ignore[arg-type]
    for more, expected in (({"strength": 2.0}, stress / 2), ({"stretch_limit": 1.5}, (stretch - 1) / 0.5)):
        for length in (0.3, 5.0):
            shape = occ.Rectangle(1, 1).Face()
            for edge in shape.edges:
                edge.name = "side"
            body = Body(shape, law.model_copy(update={**more, "rupture_length": length}), "block")
            step = simulate(BodyScene([body], [moved], levels=1, order=2, size=0.5, accuracy=inf))[-1]
            assert step.record.more["utilisation"] == pytest.approx(expected, rel=1e-8)
            assert isnan(step.record.more["utilisation_error"])  # none was asked for


def test_a_length_far_too_short_for_the_elements_is_refused():
    for sets in ("material.rupture_length=1e-5", "material.rupture_length=1e-12"):
        with pytest.raises(CaseError, match="material.rupture_length takes .* points; allowed: a longer one"):
            simulate(read_case("shear-empty-3x3", [*SMALL, "material.strength=1.0", sets]))


def test_prisms_of_a_script_are_refused():
    law = MooneyRivlin(c1=1.0, c2=0.5, bulk_modulus=10.0, strength=1.0)
    body = Body(occ.Box((0, 0, 0), (1, 1, 1)), law, "block")
    with pytest.raises(CaseError, match="allowed: in planar scenes"):
        simulate(BodyScene([body], levels=1, order=1, size=1.0, accuracy=inf))


def test_the_summary_tells_loads_cells_and_work(tmp_path):
    run = record(read_case("shear-empty-3x3", [*SMALL, "material.strength=0.0003"]), tmp_path / "out", pictures=False)
    records = list(run)
    told, utilisation = run.summary["rupture"], [one.more["utilisation"] for one in records if one.phase == "released"]
    assert told["largest_utilisation"] == max(utilisation) > 1
    low, high = told["load"]["between"]
    assert low <= told["load"]["load_factor"] <= high
    assert sum(map(len, told["cells"].values())) == 4 and told["cells"]["burst"]
    assert 0 < told["work_of_rupture"] < records[-1].energy and told["work_of_separation"] == 0
    assert told["first_separation"] is None or 0 < told["first_separation"] <= 1
    assert not np.isfinite(inf if told["load"]["error"] is None else told["load"]["error"])
