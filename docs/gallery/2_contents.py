"""What fills the cells

The same shear with empty cells, cells under pressure, cells full of a fluid, and cells full of a soft solid. A pressure
keeps walls together; a fluid has no pressure before its cell is deformed. A bar that is not certified would be grey.
"""

import matplotlib.pyplot as plt

import ngcell

contents = {
    "empty": [],
    "pressure": ["lumen.kind=pressure", "lumen.pressure=0.01"],
    "fluid": ["lumen.kind=fluid"],
    "solid": ["lumen.kind=inclusion", "lumen.material={kind='mooney-rivlin', c1=0.02, c2=0.0, bulk_modulus=1.0}"],
}
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for at, (name, settings) in enumerate(contents.items()):
    load = ["load.displacement=[0.4, 0.0]", "load.levels=1"]
    case = ngcell.read_case("shear-empty-3x3", ["accuracy=0.1", *load, *settings])
    step = ngcell.simulate(case)[-1].record
    print(f"{name}: mean gap {step.mean_gap:.4f} ± {step.mean_gap_error:.4f}, certified: {step.certified}")
    axes.bar(at, step.mean_gap, yerr=step.mean_gap_error, capsize=6, color="C0" if step.certified else "lightgrey")
axes.set_xticks(range(len(contents)), contents)
axes.set_ylabel("mean gap at a displacement of 0.4")
figure.savefig("contents.png", dpi=120)
print("picture: contents.png")
