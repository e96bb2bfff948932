"""Contact by NGSolve's boundary in scenes: patch tests, rings, and the sheared tissue, beside the package's penalty."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, NgsolveContact, Penalty, read_case
from ngcell.build.reported import Step
from tests.physics.test_patch import SPONGE, block
from tools.references.radial import RadialSolid
from tools.solutions import solved
from tools.studies.work_precision import rings


def names(step: Step) -> dict[str, float]:
    return {check.name: check.value for check in step.measurement.certificate.checks}


def confined(sizes: tuple[float, float], contact: object) -> BodyScene:
    """Two blocks between slippery walls, pressed down by a tenth."""
    material = MooneyRivlin(c1=0.8, c2=0.2, bulk_modulus=SPONGE)
    sides = [BodySupport(name, components=(True, False)) for name in ("left", "right")]
    floor = BodySupport("floor", components=(False, True))
    ceiling = BodySupport("ceiling", translation=(0.0, -0.2), components=(False, True))
    bodies = [
        Body(block(bottom, size), material, name, ("left", "right"))
        for bottom, size, name in zip((0, 1), sizes, ("lower", "upper"), strict=True)
    ]
    return BodyScene(bodies, [floor, ceiling, *sides], size=max(sizes), levels=1, contact=contact, accuracy=inf)


@pytest.mark.parametrize("sizes", [(0.25, 0.25), (0.4, 0.27)])
def test_confined_blocks_press_uniformly(sizes):
    """A penalty lets walls overlap by p / k, which the blocks are spared; meshes that do not match may add 1e-3."""
    exact = -RadialSolid(0.8, 0.2, SPONGE).slopes(1.0, 0.9)[1]
    solution = solved(confined(sizes, NgsolveContact(stiffness=100.0)))
    assert solution.certified
    pressure = solution.wall_pressures("lower-top").nominal
    matches = sizes[0] == sizes[1]
    assert -solution.resultant("ceiling")[1] == pytest.approx(exact, rel=2e-3 if matches else 4e-3)
    assert np.ptp(pressure) < (1e-6 if matches else 0.3) * pressure.mean()


@pytest.mark.parametrize("problem", ["press-fit", "above"])
def test_rings_are_those_of_the_packages_penalty(problem):
    """The same energy at the same points: all that may differ is where iterations end."""
    mine, own = (solved(rings.scene(problem, contact, 3, 0.25)) for contact in (NgsolveContact(), Penalty()))
    assert mine.certified and own.certified
    found, expected = rings.errors(problem, mine), rings.errors(problem, own)
    assert found == pytest.approx(expected, abs=1e-7)
    assert max(found.values()) < 2.5e-3
    assert names(mine.last)["pairs_of_ngsolve"] < 1e-9


def test_the_sheared_tissue_is_certified_and_that_of_the_packages_penalty():
    sets = ["tissue.rows=2", "tissue.cols=2", "load.displacement=[0.5, 0.0]", "load.levels=1", "accuracy=inf"]
    """Both integrate corners by both passes."""
    kinds = "kind='ngsolve'", "kind='penalty', single_pass_corners=false"
    mine, own = (solved(read_case("shear-empty-3x3", [*sets, f"contact={{{kind}}}"])) for kind in kinds)
    assert mine.certified and own.certified
    for name in ("energy", "plate_force_x", "contact_force", "mean_gap"):
        assert getattr(mine.last.record, name) == pytest.approx(getattr(own.last.record, name), rel=1e-6)
    assert names(mine.last)["pairs_of_ngsolve"] < 1e-9
