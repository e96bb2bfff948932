"""Bricks under shear and compression

Cells in running bond between two plates, which press on them while the upper one moves to the right.
"""

from math import hypot

import ngcell

bricks = ngcell.Brick(rows=3, cols=3, aspect=2.0, length=2.0, wall=0.12)
soft = ngcell.MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)
load = ngcell.Plates(displacement=(0.4, -0.15), levels=1)
run = ngcell.record(ngcell.Case(tissue=bricks, material=soft, load=load, accuracy=0.1), "out")
for step in run:
    if step.phase == "released":
        force = f"{hypot(step.plate_force_x, step.plate_force_y):.5f} ± {step.plate_force_error:.5f}"
        print(f"{step.plate_displacement:.2f}: force {force}, parted pairs {step.parted_pairs}")
print("certified:", run.certified)
print("picture: out/tissue.png")
