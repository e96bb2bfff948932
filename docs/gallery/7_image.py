"""Cells of a label image

A picture with a whole number for each cell, as programs for segmentation write it. Here it is drawn: each pixel
belongs to the nearest of seven points.
"""

import numpy as np
from PIL import Image

import ngcell

points = np.array([(30, 25), (90, 30), (25, 80), (70, 75), (110, 85), (35, 125), (95, 130)])
pixels = np.stack(np.meshgrid(np.arange(130), np.arange(150)), axis=-1)
labels = np.argmin(np.linalg.norm(pixels[:, :, None] - points, axis=-1), axis=-1) + 1
Image.fromarray(labels.astype(np.uint8)).save("labels.png")

cells = ngcell.LabelImage(file="labels.png", pixel=0.02, tolerance=2.0, wall=0.08)
soft = ngcell.MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)
load = ngcell.Plates(displacement=(0.5, 0.0), levels=1)
run = ngcell.record(ngcell.Case(tissue=cells, material=soft, load=load, accuracy=0.1), "out")
*_, step = run
print(f"energy {step.energy:.6f} ± {step.energy_error:.6f}")
print(f"mean gap {step.mean_gap:.4f} ± {step.mean_gap_error:.4f}, parted pairs {step.parted_pairs}")
print("certified:", run.certified)
print("picture: out/tissue.png")
