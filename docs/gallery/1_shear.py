"""A honeycomb under shear

Nine hollow cells between two plates. The upper plate moves by a fifth of the tissue's height; slits open along one
diagonal, and cells at the free sides come off.
"""

import ngcell

case = ngcell.read_case("shear-empty-3x3", ["accuracy=0.1", "load.levels=2"])
run = ngcell.record(case, "out")
for step in run:
    if step.phase == "released":
        gap = f"mean gap {step.mean_gap:.4f} ± {step.mean_gap_error:.4f}"
        print(f"{step.plate_displacement:.2f}: energy {step.energy:.6f} ± {step.energy_error:.6f}, {gap}")
print("certified:", run.certified)
print("picture: out/tissue.png")
