"""Walls that stiffen

A law of one's own, an expression of the deformation gradient: neo-Hooke, and the same with a term that stiffens with
the strain.
"""

from math import hypot

import matplotlib.pyplot as plt
import ngsolve

import ngcell


def law(stiffening):
    """Return W = 1/2 (I - 3) + b/2 (I - 3)^2 + 50 (ln J)^2, with the isochoric invariant I."""

    def energy(gradient):
        jacobian = ngsolve.Det(gradient)
        strain = ngsolve.Trace(gradient.trans * gradient) * jacobian ** (-2 / 3) - 3
        return strain / 2 + stiffening / 2 * strain**2 + 50 * ngsolve.log(jacobian) ** 2

    return ngcell.CustomLaw(energy)


figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for stiffening in (0.0, 20.0):
    tissue, load = ngcell.Tissue(rows=2, cols=3, wall=0.2), ngcell.Plates(displacement=(0.9, 0.0), levels=3)
    case = ngcell.Case(tissue=tissue, material=law(stiffening), load=load, accuracy=0.1)
    steps = [step.record for step in ngcell.simulate(case) if step.record.phase == "released"]
    forces = [hypot(step.plate_force_x, step.plate_force_y) for step in steps]
    errors = [step.plate_force_error for step in steps]
    axes.errorbar([step.plate_displacement for step in steps], forces, errors, capsize=4, label=f"b = {stiffening:g}")
    certified = all(step.certified for step in steps)
    print(f"b = {stiffening:g}: force {forces[-1]:.4f} ± {errors[-1]:.4f}, certified: {certified}")
axes.set(xlabel="plate displacement", ylabel="plate force")
axes.legend()
figure.savefig("force.png", dpi=120)
print("picture: force.png")
