"""Every shipped tissue, at a small size: it converges, is certified, and has the numbers that were recorded for it.

The shipped sizes have expected numbers of their own in their files: `python -m tools.references expected` runs them.
"""

from __future__ import annotations

import pytest

from ngcell import Case, read_case, simulate
from ngcell.scene import shipped_cases

SQUARE = ("tissue.rows=2", "tissue.cols=2")
SHEARED = (*SQUARE, "load.displacement=[0.3, 0.0]", "load.levels=1")
COARSE = ("mesh.order=1", "mesh.size=1.0")

#: Overrides, and the numbers of this program at that size, 2026.
SMALL: dict[str, tuple[tuple[str, ...], dict[str, float]]] = {
    "shear-empty": (SHEARED, {"energy": 1.6056183e-4, "plate_force_x": 8.6943359e-4, "mean_gap": 0.06188932}),
    "shear-empty-3x3": (SHEARED, {"energy": 1.6056183e-4, "plate_force_x": 8.6943359e-4}),
    "shear-empty-single-step": (SHEARED, {"energy": 1.6056183e-4, "plate_force_x": 8.6943359e-4}),
    "shear-cohesive": (
        (*SQUARE, "load.displacement=[0.1, 0.0]", "load.levels=1", "mesh.size=0.5"),
        {"energy": 1.2517249e-4, "plate_force_x": 2.5536515e-3, "mean_gap": 2.834858e-4},
    ),
    "shear-fibres": (SHEARED, {"energy": 2.0469096e-4, "plate_force_x": 1.1244310e-3, "mean_gap": 0.06292384}),
    "shear-filled": (SHEARED, {"energy": 2.1972366e-4, "plate_force_x": 1.3496320e-3, "mean_gap": 0.05848629}),
    "shear-fluid": (
        (*SQUARE, "load.displacement=[0.2, 0.0]", "load.levels=1"),
        {"energy": 9.1002348e-5, "plate_force_x": 8.7085331e-4, "mean_gap": 0.03820613},
    ),
    "shear-pressurised": (SHEARED, {"energy": 5.2271945e-4, "plate_force_x": 1.7774062e-3, "mean_gap": 0.04794932}),
    "shear-uniform-pressure": (SHEARED, {"energy": 5.0536235e-4, "plate_force_x": 1.7539089e-3}),
    # Lumens close: without their contact cells pass through themselves, and the step is not certified.
    "crush-3x3": ((), {"energy": 0.711195, "plate_force_y": -0.653319}),
    # The first tenth only: that lumens close, and more, is in its expected numbers.
    "crush-half": (("load.levels=[0.05, 0.1]", "mesh.order=3"), {"energy": 7.203185e-3, "plate_force_y": -0.05337219}),
    "frame-shear": ((*SQUARE, "load.levels=1"), {"energy": 0.033352739, "mean_gap": 0.01207421}),
    # Rows part and nothing holds them: the numbers are those of a tissue without stress.
    "stretch-plates": ((*SQUARE, "load.levels=1"), {"energy": 0.0, "plate_force_y": 0.0}),
    "bend-filled-3d": (
        ("tissue.rows=2", "tissue.height=1.0", "load.bend=5.0", "mesh.slices=2", *COARSE),
        {"energy": 0.080908945, "plate_force_z": -0.341533, "mean_gap": 1.370707e-3},
    ),
    "bend-layers-3d": (
        ("tissue.cols=1", "mesh.order=1", "mesh.slices=2"),
        {"energy": 2.145076e-3, "plate_force_z": -0.068369, "mean_gap": 0.01746339},
    ),
    "twist-closed-3d": (
        ("tissue.rows=1", "tissue.cols=2", "mesh.slices=2", *COARSE),
        {"energy": 0.089840429, "plate_force_z": -0.0424349, "mean_gap": 6.218665e-4},
    ),
    "shear-empty-3d": (
        (*SQUARE, "load.displacement=[0.2, 0.0]", "mesh.layers=1", "mesh.slices=1", *COARSE),
        {"energy": 7.600738e-4, "plate_force_x": 7.4315176e-3, "mean_gap": 0.05581829},
    ),
}
#: Gaps of cells that nothing holds depend on the path; energies and forces do not.
TOLERANCES = {"mean_gap": 1e-2}


def test_no_tissue_is_left_out():
    assert set(SMALL) == {name for name in shipped_cases() if isinstance(read_case(name), Case)}
    assert not {name for name in SMALL if not read_case(name).expected}


@pytest.mark.parametrize("name", SMALL)
def test_a_small_tissue_has_its_numbers(name):
    overrides, numbers = SMALL[name]
    *_, step = simulate(read_case(name, [*overrides, "accuracy=inf"]))
    assert step.record.certified
    for quantity, value in numbers.items():
        found = getattr(step.record, quantity)
        assert found == pytest.approx(value, rel=TOLERANCES.get(quantity, 1e-4), abs=1e-8), quantity
