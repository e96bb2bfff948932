"""A honeycomb whose corners have moved: at nothing the honeycomb, and else cells that still share their walls."""

from __future__ import annotations

from math import inf

import ngsolve
import numpy as np
import pytest

from ngcell import MeshChoice, Perturbed, Tissue, simulate
from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.tie import coincident_facets
from ngcell.scene import Case, read_case
from tests.prisms import MATERIAL

SIZE = {"rows": 3, "cols": 3, "wall": 0.1}
PARTS = [{}, {"orientation": "flat"}, {"corner_radius": 0.2}, {"height": 0.6, "end_wall": 0.1, "layers": 2}]


def points(bodies) -> np.ndarray:
    return np.array([vertex.point for vertex in bodies.mesh.vertices])


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("filled", [False, True])
def test_without_spread_it_has_the_nodes_of_the_honeycomb(part, filled):
    choice = MeshChoice(grading=2)
    one = Tissue(**SIZE, **part).mesh("plates", choice, filled=filled)
    two = Perturbed(**SIZE, **part, spread=0.0, seed=5).mesh("plates", choice, filled=filled)
    np.testing.assert_allclose(points(two), points(one), atol=1e-13)
    assert two.mesh.GetBoundaries() == one.mesh.GetBoundaries()


def sheared(tissue: dict[str, object]) -> float:
    load = {"kind": "plates", "displacement": [0.3, 0.0], "levels": 1}
    table = {"tissue": {"rows": 2, "cols": 2, "wall": 0.1, **tissue}, "material": MATERIAL, "load": load}
    return simulate(Case.model_validate({**table, "accuracy": inf}))[-1].record.energy


def test_without_spread_a_sheared_tissue_stores_the_energy_of_the_honeycomb():
    regular = sheared({})
    assert regular > 1e-5
    assert sheared({"kind": "perturbed", "spread": 0.0, "seed": 4}) == pytest.approx(regular, rel=1e-12)
    assert 1e-6 < abs(sheared({"kind": "perturbed", "spread": 1e-3, "seed": 4}) / regular - 1) < 0.02


@pytest.mark.parametrize("part", PARTS)
def test_neighbours_share_their_walls_node_by_node(part):
    choice = MeshChoice(grading=1)
    tissues = [Tissue(**SIZE, **part), Perturbed(**SIZE, **part, spread=0.2, wall_spread=0.3, seed=1)]
    spaces = [DisplacementSpace(tissue.mesh("frame", choice), 2) for tissue in tissues]
    walls = [find_surface(space.bodies, space.scalar, space.rest) for space in spaces]
    regular, perturbed = (len(coincident_facets(surface)) for surface in walls)
    assert perturbed == regular > 0
    assert len(find_facing(walls[1], 1e-6).pairs) == len(find_facing(walls[0], 1e-6).pairs)


@pytest.mark.parametrize("orientation", ["pointy", "flat"])
def test_corners_move_by_up_to_the_spread_and_those_on_plates_along_x_only(orientation):
    size = SIZE | {"orientation": orientation}
    regular = Tissue(**size).outlines
    moved = Perturbed(**size, spread=0.1, seed=2).outlines.corners - regular.corners
    twice = Perturbed(**size, spread=0.2, seed=2).outlines.corners - regular.corners
    np.testing.assert_allclose(twice, 2 * moved, atol=1e-14)
    distance = np.linalg.norm(moved, axis=1)
    assert 0.08 < distance.max() <= 0.1 and distance.min() > 0
    height = regular.corners[:, 1]
    ends = (height < height.min() + 1e-9) | (height > height.max() - 1e-9)
    assert ends.sum() > 4 and (moved[ends, 1] == 0).all()
    assert (moved[:, 1] != 0).sum() > len(moved) / 2
    other = Perturbed(**size, spread=0.1, seed=3).outlines.corners - regular.corners
    assert np.abs(other - moved).max() > 0.01


def test_walls_have_the_thickness_of_their_cells():
    tissue = Perturbed(**SIZE, spread=0.0, wall_spread=0.5, seed=7)
    mesh = tissue.mesh("plates", MeshChoice()).mesh
    thickness = np.asarray(tissue.walls)
    assert 0.05 < thickness.min() < 0.08 and 0.12 < thickness.max() < 0.15
    for cell, wall in enumerate(thickness):
        area = 1.5 * np.sqrt(3) * (1 - (1 - wall / tissue.apothem) ** 2)
        found = ngsolve.Integrate(1, mesh, definedon=mesh.Materials(f"cell{cell}"))
        assert found == pytest.approx(area, rel=1e-12)


def test_irregular_lumens_are_filled_to_the_last_element():
    tissue = Perturbed(**SIZE, spread=0.2, seed=3)
    bodies = tissue.mesh("plates", MeshChoice(grading=2), filled=True)
    area = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh, element_wise=True).NumPy()
    jacobian = ngsolve.Det(ngsolve.specialcf.JacobianMatrix(2))
    assert ngsolve.Integrate(ngsolve.IfPos(jacobian, 0, 1), bodies.mesh) == 0
    np.testing.assert_allclose(
        np.bincount(bodies.body_of_element, area), tissue.outlines.areas, rtol=1e-12
    )


def test_any_honeycomb_case_is_perturbed_by_overrides():
    overrides = ["tissue.kind=perturbed", "tissue.spread=0.01", "tissue.seed=3"]
    case = read_case("shear-empty-3x3", overrides)
    assert case.tissue == Perturbed(rows=3, cols=3, wall=0.1, spread=0.01, seed=3)
    assert read_case("shear-empty-3x3", [*overrides, "tissue.corner_radius=0.1"]).tissue.corner_radius == 0.1


@pytest.mark.parametrize(
    ("entries", "says"),
    [
        (("tissue.spread=0.5",), "tissue.spread = 0.5 is not possible; allowed: a finite number >= 0 and < 0.5"),
        (("tissue.spread=0.1", "tissue.seed=-1"), "tissue.seed = -1 is not possible; allowed: a whole number >= 0"),
        (
            ("tissue.spread=0.45", "tissue.wall=0.6", "tissue.seed=1"),
            r"tissue.spread = 0.45: cell \d, about \(.*\): its wall of 0.6 closes its lumen, or one side of it; "
            r"allowed: 0 < wall < 0.\d+ in this cell.*; or a smaller spread",
        ),
    ],
)
def test_what_leaves_no_lumen_is_refused(entries, says):
    with pytest.raises(CaseError, match=says):
        read_case("shear-empty-3x3", ["tissue.kind=perturbed", *entries])


@pytest.mark.parametrize("part", PARTS[:3])
def test_halved_elements_keep_the_nodes_of_those_that_they_halve(part):
    """So what is found on one mesh is a function on the other; no element is added in graded parts of walls."""
    tissue = Perturbed(**SIZE, **part, spread=0.1, seed=1)
    whole, halved = (tissue.mesh("plates", MeshChoice(grading=1, halvings=count)) for count in (0, 1))
    coarse, fine = points(whole), points(halved)
    near = np.linalg.norm(coarse[:, None] - fine[None], axis=2).min(axis=1)
    assert near.max() < 1e-12
    assert whole.mesh.ne < halved.mesh.ne < 2 * whole.mesh.ne


@pytest.mark.parametrize("entries", [{"spread": 0.4, "corner_radius": 0.7}, {"wall_spread": 0.8, "corner_radius": 0.5}])
def test_round_corners_that_do_not_fit_displaced_cells_are_refused(entries):
    with pytest.raises(CaseError, match="round corners of cell .*allowed: 0 <= corner_radius"):
        Perturbed(rows=4, cols=4, side=1.0, wall=0.12, **({"spread": 0.1} | entries))
