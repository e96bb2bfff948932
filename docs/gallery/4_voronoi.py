"""Voronoi cells in a frame

Twelve Voronoi cells whose outer walls follow a shear. Each is stretched along one diagonal and squeezed along the
other.
"""

import ngcell

cells = ngcell.Voronoi(cells=12, extent=(4.0, 3.0), seed=4, relaxation=3, wall=0.08)
soft = ngcell.MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)
load = ngcell.Frame(shear=0.2, levels=1)
run = ngcell.record(ngcell.Case(tissue=cells, material=soft, load=load, accuracy=0.1), "out")
*_, step = run
print(f"energy {step.energy:.5f} ± {step.energy_error:.5f}")
print(f"mean gap {step.mean_gap:.4f} ± {step.mean_gap_error:.4f}, parted pairs {step.parted_pairs}")
print("certified:", run.certified)
print("picture: out/tissue.png")
