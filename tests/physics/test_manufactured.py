"""Contact at large strain with a known answer: loads that are right, and errors that fall as fast as they should."""

from __future__ import annotations

from math import log

import ngsolve
import numpy as np
import pytest

from ngcell.build.simulation import Simulation
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from tools.references.manufactured import C1, C2, END, KAPPA, PROBLEMS, Exact, errors, first_piola, scene


def test_the_stress_is_the_derivative_of_the_stored_energy():
    mesh = Simulation(scene(Exact("touching"), "penalty", 1, 0.25)).bodies.mesh
    law, step = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA), 1e-6
    at = np.array([1.3, 0.4, -0.2, 0.7])

    def energy(entries: np.ndarray) -> float:
        gradient = ngsolve.CF(tuple(map(float, entries)), dims=(2, 2))
        return law.stored_energy(gradient)(mesh(0.3, 0.3))

    slopes = [(energy(at + step * way) - energy(at - step * way)) / (2 * step) for way in np.eye(4)]
    assert first_piola(*at) == pytest.approx(slopes, rel=1e-8)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_the_chosen_walls_touch_up_to_the_end_and_the_supports_follow_them(problem):
    exact = Exact(problem)
    simulation = Simulation(scene(exact, "penalty", 4, 0.1))
    mesh, space = simulation.bodies.mesh, simulation.space
    for above in np.linspace(0.05, 0.95, 19):
        below = float(above + 0.03 * np.sin(2 * np.pi * above))
        up, down = (
            np.array(exact.displacement[body](mesh(place, 0.0))) + (place, 0.0)
            for body, place in (("above", above), ("below", below))
        )
        opens = problem == "opening" and above > END
        np.testing.assert_allclose((up - down)[0], 0, atol=1e-14)
        assert (up - down)[1] > 1e-5 if opens else abs((up - down)[1]) < 1e-14
        assert (exact.pressure(below) == 0) == opens or problem == "touching"
    chosen = ngsolve.GridFunction(space.vector)
    chosen.Set(mesh.MaterialCF(exact.displacement))
    at = chosen.vec.FV().NumPy().copy()
    np.testing.assert_allclose(simulation.motion.imposed(at, 1.0), at, atol=1e-5)


@pytest.mark.parametrize(
    ("order", "finest", "least"),
    [
        (1, 0.125, {"displacement": 2.0, "gradient": 1.0}),  # pressures reach their 0.5 on finer meshes only
        (2, 0.125, {"displacement": 2.5, "gradient": 1.5, "pressure": 1.0}),
    ],
)
def test_errors_fall_at_the_rates_of_large_strain_contact(order, finest, least):
    coarse, fine = (errors("opening", "mortar", order, size) for size in (0.25, finest))
    rates = {name: log(coarse[name] / fine[name]) / log(0.25 / finest) for name in least}
    assert coarse["certified"] and fine["certified"]
    assert all(rates[name] >= least[name] for name in least), rates
