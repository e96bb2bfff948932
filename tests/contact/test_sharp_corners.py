"""Corners of cells drawn out to needles exert no force on a wall beside them."""

from ngcell import read_case
from ngcell.build.simulation import Simulation

SETS = (
    "tissue.rows=2",
    "tissue.cols=2",
    'load.kind="frame"',
    "load.shear=-2.0",
    "load.levels=1",
    'strategy.kind="single-step"',
)


def test_a_far_sheared_frame_is_certified():
    (step,) = Simulation(read_case("frame-shear", [*SETS, "accuracy=inf"])).accepted_steps()
    assert step.measurement.certificate.passed
    assert step.record.energy > 0
