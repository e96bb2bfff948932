"""A strategy of one's own: up to the full load and back; frictionless contact forgets the way."""

import pytest

from ngcell import Case, MeshChoice, MooneyRivlin, Plates, Tissue, simulate


class ThereAndBack:
    steps = None

    def follow(self, task, progress):
        for load in (*task.levels, *task.levels[-2::-1]):
            lifting = task.motion.lifting(load)
            yield task.released.step(lifting, lifting, load)


rubber, cells = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0), Tissue(rows=2, cols=2, wall=0.15)
load, mesh = Plates(displacement=(0.2, 0.0), levels=2), MeshChoice(order=2)
steps = simulate(Case(tissue=cells, material=rubber, load=load, mesh=mesh), strategy=ThereAndBack())
assert [step.record.load_factor for step in steps] == [0.5, 1.0, 0.5]
assert steps[2].record.energy == pytest.approx(steps[0].record.energy, rel=1e-9)
