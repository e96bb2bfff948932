"""Gaps in the history: those between cells that something holds, and apart from them those of cells that nothing does.

Where a free cell lies is up to the proximal term that holds it still, and says nothing of the tissue.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.mechanics.report import Scales
from ngcell.results import equilibrium
from ngcell.results.equilibrium import Balance, balance_of
from ngcell.results.forces import ContactForces

PLAIN = ["load.levels=1", "mesh.order=2", "accuracy=inf"]
SCENES = {
    "sheared": ("shear-empty-3x3", PLAIN),
    "halves of prisms, which supports hold along their axes": (
        "shear-empty-3x3",
        [*PLAIN, "tissue.cols=2", "tissue.height=0.4", 'load.ends="mirrored"', "mesh.slices=1", "mesh.layers=1",
         "mesh.size=1.0"],
    ),
    "a row between two that are pulled apart": ("stretch-plates", [*PLAIN, "tissue.rows=3", "tissue.cols=2"]),
}


@pytest.mark.parametrize("scene", SCENES)
def test_walls_of_free_cells_are_counted_apart(scene: str):
    *_, step = ngcell.simulate(ngcell.read_case(*SCENES[scene]))
    free, record = set(step.measurement.free_bodies), step.record
    of_free = [wall for wall in step.walls if {wall.cell_a, wall.cell_b} & free]
    held = [wall for wall in step.walls if not {wall.cell_a, wall.cell_b} & free]
    assert of_free and held
    assert record.largest_gap == max(wall.largest_gap for wall in held)
    assert record.free_largest_gap == max(wall.largest_gap for wall in of_free) > record.largest_gap
    # Walls of all cells are equally long.
    assert record.mean_gap == pytest.approx(sum(wall.mean_gap for wall in held) / len(held), rel=1e-9)
    assert record.free_mean_gap == pytest.approx(sum(wall.mean_gap for wall in of_free) / len(of_free), rel=1e-9)


def test_a_contact_that_is_not_balanced_yet_holds_nothing():
    """A free cell that has been moved a little against another is pressed by it, and flies off."""
    scene = Simulation(ngcell.read_case("shear-empty-3x3", PLAIN))
    *_, accepted = scene.follow(scene.start)
    problem, minimum = scene.problem_of("released"), accepted.minimum

    def balance(displacement: np.ndarray) -> Balance:
        pull = -minimum.proximal.gradient(displacement, problem.metric)
        return balance_of(scene.setup, problem, problem.at(displacement), pull)

    at_rest = minimum.state.displacement
    free, pressed = balance(at_rest).free_bodies, 0
    assert free
    for body in free:
        cell = np.where(problem.space.body_of_unknown == body, problem.space.one, 0.0)
        for direction in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            found = balance(at_rest + 0.01 * np.outer(direction, cell).ravel())
            forces = np.linalg.norm(found.forces.force, axis=1)[(found.forces.bodies == body).any(axis=1)]
            if np.count_nonzero(forces) == 1 and forces.max() > 1e-6:  # by one other cell, with nothing against it
                pressed += 1
                assert body in found.free_bodies
    assert pressed


def test_what_dozens_of_loose_cells_hand_on_to_each_other_holds_none_of_them():
    """Thirty cells in a row, each pulled towards the next, lean on three that press each other."""
    loose, count, pull = 30, 33, 1e-4
    ends = np.array([*((cell, cell + 1) for cell in range(loose)), (30, 31), (31, 32)])
    sizes = np.array([*(pull * (cell + 1) for cell in range(loose)), 1.0, 1.0])
    forces = ContactForces(
        bodies=ends,
        force=sizes[:, None] * [-1.0, 0.0],
        on_body=np.zeros((count, 2)),
        pressed=np.bincount(ends.ravel(), np.repeat(sizes, 2)),
        normal=sizes,
    )
    pulls = np.where(np.arange(count) < loose, pull, 0.0)[:, None] * [1.0, 0.0]
    space = SimpleNamespace(resultants=lambda part: part, body_of_unknown=np.arange(count))
    problem = SimpleNamespace(unknowns=SimpleNamespace(lets_bodies_part=True), space=space)
    setup = SimpleNamespace(modulus=1.0, motion=SimpleNamespace(fixed=np.zeros((2, count), dtype=bool)))
    scales = Scales(force=1.0, energy=1.0, thickness=1.0, stored=2.0)
    found = equilibrium._held_by_nothing(problem, setup, scales, forces, pulls, 0 * pulls)
    assert found == tuple(range(loose))
