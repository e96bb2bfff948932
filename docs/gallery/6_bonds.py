"""Bonds that break

Nine cells whose walls are bonded. The force grows until bonds break; where walls snap apart, it falls while the plates
stand still. Scenes with bonds have no estimated error; the energy balance is the check.
"""

import matplotlib.pyplot as plt

import ngcell

settings = ["load.displacement=[1.0, 0.0]", "load.levels=4"]
bonds = ["cohesion.strength=0.05", "cohesion.energy=0.0015", "strategy.kind=load-stepping"]
case = ngcell.read_case("shear-empty-3x3", [*settings, *bonds])
steps = [step.record for step in ngcell.simulate(case)]
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
axes.plot([step.plate_displacement for step in steps], [step.plate_force_x for step in steps], "o-")
axes.set(xlabel="plate displacement", ylabel="plate force")
figure.savefig("force.png", dpi=120)
last = steps[-1]
print(f"{len(steps)} steps, largest force {max(step.plate_force_x for step in steps):.4f}")
print(f"energy of separation {last.separation_energy:.5f}, lost as walls snapped {last.dissipation:.5f}")
print(f"still bonded: {last.bonded_share:.0%}, certified: {all(step.certified for step in steps)}")
print("picture: force.png")
