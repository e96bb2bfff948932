"""What the certificate refuses, on small scenes from end to end."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import inf

import numpy as np
import pytest
from netgen import occ

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.errors import CaseError
from ngcell.mechanics.report import Scales
from ngcell.results.certificate import HELD, common_check
from ngcell.results.checks import NodalForces, Path, _plate_balance, _stabilisation, scales_of
from ngcell.results.measure import Measurement, WorkPoint, measure
from ngcell.scene import Body, BodyScene, BodySupport, Case, MooneyRivlin, read_case

SOFT = {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0}


def tissue(displacement: tuple[float, float], *, kappa: float = 100.0, cols: int = 1, levels: int = 1) -> Simulation:
    case = Case.model_validate(
        {
            "title": "cells",
            "tissue": {"rows": 1, "cols": cols, "side": 1.0, "wall": 0.1},
            "material": {**SOFT, "bulk_modulus": kappa},
            "mesh": {"order": 2},
            "load": {"kind": "plates", "displacement": list(displacement), "levels": levels},
            "strategy": {"kind": "sddp"},
            "accuracy": inf,
        }
    )
    return Simulation(case)


def block(name: str, low: tuple[float, float], high: tuple[float, float], kappa: float = 50.0) -> Body:
    face = occ.MoveTo(*low).Rectangle(high[0] - low[0], high[1] - low[1]).Face()
    for side, direction in (("left", -occ.X), ("right", occ.X), ("bottom", -occ.Y), ("top", occ.Y)):
        face.edges.Max(direction).name = f"{name}_{side}"
    return Body(face, MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=kappa), name, ())


@cache
def sheared() -> tuple[Simulation, list[Step]]:
    simulation = tissue((0.2, 0.0), cols=2, levels=2)
    return simulation, list(simulation.accepted_steps())


def value(measurement: Measurement, name: str) -> float:
    return next(check.value for check in measurement.certificate.checks if check.name == name)


def measured(displacement: np.ndarray, path: Path, before: WorkPoint | None = None) -> Measurement:
    """Measure a displacement as the last released step of the sheared tissue."""
    simulation, _ = sheared()
    problem = simulation.problem
    problem.apply(1.0)
    nothing, state = np.zeros(simulation.space.unknowns), problem.at(displacement)
    return measure(simulation.setup, problem, state, load_factor=1.0, proximal_force=nothing, before=before, path=path)


def test_released_walls_store_less_than_the_tied_solid():
    _, steps = sheared()
    for tied, released in zip(steps[::2], steps[1::2], strict=True):
        assert value(released.measurement, "energy_above_tied") == 0
        assert released.record.energy < tied.record.energy
        assert released.record.certified
        assert np.array_equal(released.checkpoint.reported["tied"], tied.displacement)
    assert "energy_above_tied" not in {check.name for check in steps[0].measurement.certificate.checks}


def test_released_walls_above_the_tied_solid_are_refused():
    simulation, steps = sheared()
    tied, released = steps[-2].displacement, steps[-1].displacement
    excess = np.where(simulation.problem.free, tied - released, 0.0)
    path = Path(tied=simulation.space.configuration(tied))
    above = measured(tied + 0.3 * excess, path)
    # Less than the whole difference: at corners, contact sees tied walls overlap.
    whole = 1 - steps[-2].record.energy / above.energy
    assert 0.9 * whole < value(above, "energy_above_tied") <= whole
    assert "energy_above_tied" in above.certificate.failures
    assert "energy_above_tied" not in measured(released, path).certificate.failures


def test_energy_that_nothing_supplied_is_refused_where_states_follow_each_other():
    _, steps = sheared()
    last = steps[-1]
    poor = replace(last.measurement.work, load_factor=0.99, energy=0.5 * last.record.energy)
    rich = replace(poor, energy=2 * last.record.energy)
    assert measured(last.displacement, Path(follows=True), poor).unstored_work < 0
    assert "work_mismatch" in measured(last.displacement, Path(follows=True), poor).certificate.failures
    assert "work_mismatch" not in measured(last.displacement, Path(follows=True), rich).certificate.failures
    assert "work_mismatch" not in measured(last.displacement, Path(), poor).certificate.failures


def test_a_cell_whose_walls_fold_through_each_other_is_refused():
    """Between plates that nearly meet, the walls of a lone cell have no place."""
    *_, last = tissue((0.0, -0.98)).accepted_steps()
    failures = last.measurement.certificate.failures
    assert {"smallest_jacobian", "self_penetration_over_wall", "quadrature_error"} & set(failures)


def test_energies_that_the_rule_misses_are_refused():
    """At this bulk modulus, the largest with the full rule, walls of order 2 lock, and it misses energy in between."""
    *_, last = tissue((0.2, 0.0), kappa=2e3).accepted_steps()
    assert "quadrature_error" in last.measurement.certificate.failures


@pytest.mark.parametrize("fall", [-1.0, -1.2, -2.5])
def test_plates_that_pass_each_other_are_no_load(fall):
    with pytest.raises(CaseError, match=r"passes the lower one, 1 below it; allowed: .* above -1"):
        tissue((0.3, fall))


@pytest.mark.parametrize("lumen", [None, {"kind": "fluid", "fill": 0.75}])
def test_plates_that_meet_at_rest_are_no_load(lumen):
    """Both hold the corners at half of the height of a lone cell that lies on a side."""
    entries = {
        "tissue": {"rows": 1, "cols": 1, "wall": 0.1, "orientation": "flat"},
        "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 50.0},
        "load": {"kind": "plates", "displacement": [0.0, 0.1]},
        "accuracy": np.inf,
        **({} if lumen is None else {"lumen": lumen}),
    }
    with pytest.raises(CaseError, match="plates are not apart at rest"):
        Simulation(Case.model_validate(entries))


def test_plates_that_keep_their_sides_are_a_load():
    assert tissue((5.0, -0.99)).levels == (1.0,)


def test_two_blocks_at_the_same_place_are_refused():
    bodies = [block(name, (0, 0), (1, 1)) for name in ("one", "two")]
    supports = [BodySupport(f"{body.name}_bottom") for body in bodies]
    (step,) = Simulation(BodyScene(bodies, supports, size=0.5, order=2, levels=1, accuracy=inf)).accepted_steps()
    assert "penetration_over_wall" in step.measurement.certificate.failures


@pytest.mark.parametrize("kappa", [5e3, 1e5, 1e7])
def test_a_confined_stack_is_certified_however_stiff(kappa):
    """Two blocks with held sides, pressed by 2 %: homogeneous, and the overlap is nothing beside that."""
    bodies = [block("lower", (0, 0), (0.5, 0.5), kappa), block("upper", (0, 0.5), (0.5, 1), kappa)]
    bodies = [
        replace(body, untouched=tuple(f"{body.name}_{side}" for side in ("left", "right", outer)))
        for body, outer in zip(bodies, ("bottom", "top"), strict=True)
    ]
    sides = [
        BodySupport(f"{body.name}_{side}", components=(True, False)) for body in bodies for side in ("left", "right")
    ]
    bottom = BodySupport("lower_bottom", components=(False, True))
    top = BodySupport("upper_top", translation=(0.0, -0.02), components=(False, True))
    (step,) = Simulation(
        BodyScene(bodies, [*sides, bottom, top], size=0.2, order=2, levels=1, accuracy=inf)
    ).accepted_steps()
    assert step.record.certified, step.measurement.certificate.failures
    # Nearly all of the energy is that of the volume; the overlap takes a little of the way.
    assert step.record.energy == pytest.approx(0.5 * kappa / 2 * np.log(0.98) ** 2, rel=0.02)


@pytest.mark.parametrize("name", HELD)
def test_the_proximal_term_may_hold_a_tenth_of_the_accuracy_and_what_it_always_could_without_one(name):
    assert common_check(name, 0.009, accuracy=0.1).passed and not common_check(name, 0.011, accuracy=0.1).passed
    assert not common_check(name, 0.0011, accuracy=0.01).passed and common_check(name, 0.0009).passed
    assert not common_check(name, 0.0011).passed
    # What is no matter of the proximal term does not depend on it.
    assert not common_check("residual", 2e-6, accuracy=0.1).passed


@pytest.mark.parametrize(("cells", "largest", "expected"), [(10, 1.0, 0.01), (1, 1.0, 0.1), (1, 4.0, 0.025)])
def test_plates_are_balanced_beside_the_force_from_one_to_the_other(cells, largest, expected):
    """Each cell at a plate is pressed by one, and all together are out of balance by a tenth."""
    held = np.repeat([[1.0, 0.0], [-1.0, 0.0]], cells, axis=0)
    loaded = np.zeros_like(held)
    loaded[0, 0] = 0.1
    assert _plate_balance(held, loaded, largest) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("stored", "pull", "share"),
    [(1e-11, 5e-7, 0.0), (1e-11, 2e-6, 0.2), (1e-9, 5e-7, 0.05)],
    ids=["nothing", "more than nothing", "walls are strained"],
)
def test_what_the_proximal_term_takes_of_nothing_is_nothing(stored: float, pull: float, share: float):
    """A force of 1e-5 hardly strains a wall, which then stores 1e-8; nothing is a tenth of that strain."""
    nothing = np.zeros(2)
    nodal = NodalForces(nothing, nothing, nothing, np.array([pull, 0.0]))
    assert _stabilisation(nodal, Scales(1e-5, 1e-8, 0.1, stored)) == pytest.approx(share, abs=1e-12)


@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_what_counts_as_nothing_of_prisms_is_the_same_in_any_unit(unit):
    lattice = ["tissue.rows=1", "tissue.cols=1", f"tissue.side={unit}", f"tissue.wall={0.2 * unit}"]
    prism = Simulation(read_case("shear-empty-3d", [*lattice, f"tissue.height={unit}", "expected=[]"]))
    one = scales_of(prism.space, 2.0, 0.0)
    volume = 1.5 * np.sqrt(3) * (1 - (1 - 0.4 / np.sqrt(3)) ** 2)
    assert one.force / unit**2 == pytest.approx(1e-4 * 2.0 * 0.2 * np.sqrt(volume / 0.2), rel=1e-9)
    assert one.thickness == pytest.approx(0.2 * unit, rel=1e-9)
