"""The meshes that a scene is taken to, and the singularity that says how their errors fall."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from netgen import occ
from scipy.optimize import brentq

from ngcell import Body, BodyScene, Case, MooneyRivlin, read_case
from ngcell.build.simulation import Simulation
from ngcell.build.stages import singular_exponent, stages_of
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.space import DisplacementSpace
from tests.prisms import MATERIAL, case
from tests.tissues import small_tissue

RUBBER = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=10.0)


def steps(scene: object) -> list[tuple[int, int]]:
    return [(stage.order, stage.grading) for stage in stages_of(scene)]  # type: ignore[arg-type]


def block_scene(**more: object) -> BodyScene:
    return BodyScene([Body(occ.Rectangle(1, 1).Face(), RUBBER, "block")], **more)  # type: ignore[arg-type]


def space_of(face: occ.Face, order: int = 2) -> DisplacementSpace:
    return DisplacementSpace(mesh_shapes([face], ["body"], order=order, size=0.3), order)


def test_a_free_reentrant_corner_has_the_exponent_of_williams():
    """The corners of a hexagonal lumen turn through 240 degrees in the wall, that of an L through 270."""
    assert singular_exponent(small_tissue(1, 1, order=2).space) == pytest.approx(0.6157, abs=1e-4)
    bracket = occ.Rectangle(1, 1).Face() - occ.MoveTo(0.5, 0.5).Rectangle(0.5, 0.5).Face()
    assert singular_exponent(space_of(bracket)) == pytest.approx(0.5445, abs=1e-4)


def test_what_fills_a_lumen_does_not_hide_the_corners_of_its_wall():
    """It is much softer: taken for a corner that is held, errors of filled cells were told a fifth too small."""
    one = read_case("shear-filled", ["tissue.rows=1", "tissue.cols=1"])
    assert singular_exponent(Simulation(one).space) == pytest.approx(0.6157, abs=1e-4)


def wedge_exponent(filling: tuple[float, float]) -> float:
    """The smallest exponent of a wall of 240 degrees with a filling (shear and bulk modulus) in plane strain.

    Both have Airy's functions r^(x + 1) (A cos((x + 1) t) + B cos((x - 1) t)) about the bisector (Williams 1952);
    displacements and tractions are the same where they meet.
    """
    wall = 2.0, 100.0

    def fields(x: float, angle: float, moduli: tuple[float, float]) -> np.ndarray:
        shear, bulk = moduli
        kolosov = 3 - 2 * (3 * bulk - 2 * shear) / (3 * bulk + shear)
        one, two = (x + 1) * angle, (x - 1) * angle
        first = [-(x + 1) * np.cos(one), (x + 1) * np.sin(one)]
        second = [(kolosov - x) * np.cos(two), (kolosov + x) * np.sin(two)]
        tractions = [x * (x + 1) * np.cos([one, two]), x * np.array([(x + 1) * np.sin(one), (x - 1) * np.sin(two)])]
        return np.vstack([np.column_stack([first, second]) / (2 * shear), tractions])

    def determinant(x: float) -> float:
        both = np.hstack([fields(x, np.radians(120), wall), -fields(x, np.radians(-60), filling)])
        both[:2] *= 2 * min(wall[0], filling[0])
        return float(np.linalg.det(both / np.abs(both).max(axis=0)))

    return float(brentq(determinant, 0.5, 0.75))


def test_the_corner_of_a_filled_wall_is_nearly_as_singular_as_a_free_one():
    """What fills the shipped cells has a two-hundredth of the shear modulus of their walls."""
    assert wedge_exponent((1e-9, 1e-9)) == pytest.approx(0.6157, abs=1e-4)
    assert wedge_exponent((0.01, 10.0)) == pytest.approx(0.621, abs=1e-3)
    assert wedge_exponent((0.1, 100.0)) == pytest.approx(0.663, abs=1e-3)


def test_without_corners_the_end_of_a_contact_rules():
    ring = occ.Circle((0.0, 0.0), 1.0).Face() - occ.Circle((0.0, 0.0), 0.5).Face()
    assert singular_exponent(space_of(ring)) == 1.5  # curved edges of a coarse mesh have no corners between them


def test_a_corner_that_sticks_out_may_be_held_on_one_side():
    assert 0.7 < singular_exponent(space_of(occ.Rectangle(1, 1).Face())) < 0.72


def test_meshes_grow_and_the_finest_is_for_a_high_accuracy():
    meshes = steps(read_case("shear-empty-3x3", ["accuracy=0.01"]))
    assert meshes[0] == (2, 1) and meshes[-1] == (6, 3)
    assert steps(read_case("shear-empty-3x3", ["accuracy=0.02"])) == meshes[:-1]
    assert [one < two for one, two in zip(meshes, meshes[1:], strict=False)] == [True] * (len(meshes) - 1)


def halvings(case: str, *changes: str) -> set[int | None]:
    return {stage.scene.mesh.halvings for stage in stages_of(read_case(case, changes))}  # type: ignore[union-attr]


def test_hollow_cells_take_shorter_elements_for_a_high_accuracy():
    """Their cells slide on from mesh to mesh otherwise: of five scenes of 35 of them two were certified."""
    assert halvings("shear-empty", "accuracy=0.01") == halvings("shear-empty", "accuracy=0.03") == {1}
    noisy = ('tissue.kind="perturbed"', "tissue.spread=0.03", "tissue.seed=1")
    assert halvings("shear-empty-3x3", *noisy) == halvings("shear-empty-3x3", "accuracy=0.003") == {1}
    assert halvings("shear-empty", "accuracy=0.01", "mesh.size=0.5") == {None}
    assert halvings("shear-empty", "accuracy=0.01", "mesh.halvings=2") == {2}
    assert halvings("shear-empty", "accuracy=0.05") == halvings("shear-empty-3x3") == {None}
    assert halvings("shear-filled", "accuracy=0.01") == {None}


def test_a_tissue_that_does_not_tell_its_outlines_takes_shorter_elements_as_well():
    case = read_case("shear-empty-3x3")
    told = case.tissue

    class Untold:
        cell_count, grid, height = told.cell_count, told.grid, told.height

        def mesh(self, *given: object, **named: object) -> object:
            return told.mesh(*given, **named)  # type: ignore[arg-type]

    untold = case.model_copy(update={"tissue": Untold()})
    assert {stage.entries["halvings"] for stage in stages_of(untold)} == {1}
    assert {stage.entries["halvings"] for stage in stages_of(case)} == {0}


def test_the_summary_names_meshes_as_a_case_does():
    meshes = [stage.entries for stage in stages_of(read_case("shear-empty", ["accuracy=0.01"]))]
    assert meshes[0] == {"order": 2, "grading": 1, "halvings": 1}


def test_before_a_mesh_is_graded_its_order_has_told_the_error():
    """A grade leaves what it does not reach, which is known only from an error that was told before."""
    stages = stages_of(read_case("shear-empty-3x3"))
    kinds = [two.refining(one, 0.6) for one, two in zip(stages, stages[1:], strict=False)]
    first = next(number for number, kind in enumerate(kinds) if kind.is_graded)
    assert first >= 2 and not kinds[first - 1].is_graded
    assert kinds[0].remains == pytest.approx((2.5 / 3.5) ** 2.4)
    assert kinds[0].remains_of_gaps == pytest.approx((2 / 3) ** 2.4)
    assert kinds[first].remains == pytest.approx(0.2**1.2)


def test_where_no_error_is_to_be_estimated_there_is_the_mesh_of_the_case_alone():
    assert steps(read_case("shear-empty-3x3", ["accuracy=inf"])) == [(3, 0)]
    assert steps(read_case("stacked-blocks", ["accuracy=inf"]))[0][1] == 0
    assert steps(block_scene(accuracy=inf)) == [(2, 0)]


def test_an_order_that_is_given_is_kept_and_one_more_serves_the_estimate():
    for scene in (case(None, accuracy=0.01), block_scene(order=2)):
        kept, finer = stages_of(scene)
        assert (kept.order, finer.order) == (2, 3)
        assert kept.is_reported and not finer.is_reported


def test_the_highest_order_is_estimated_by_one_that_nobody_may_give():
    given = read_case("shear-empty-3x3", ["mesh.order=6"]), read_case("stacked-blocks", ["mesh.order=6"])
    for scene in (*given, block_scene(order=6)):
        kept, finer = (stage.scene for stage in stages_of(scene))
        assert [getattr(one, "mesh", one).order for one in (kept, finer)] == [6, 7]


def test_filled_irregular_cells_begin_at_an_order_that_settles_their_walls():
    """At order 2 their walls end up where order 3 does not leave them."""
    tissue = {"kind": "voronoi", "cells": 9, "extent": [5.0, 5.0], "seed": 2, "wall": 0.1}
    solid = {"kind": "inclusion", "material": {**MATERIAL, "c1": 0.01}}
    load = {"kind": "plates", "stretch": 0.98, "levels": 1}
    entries = {"title": "filled", "tissue": tissue, "material": MATERIAL, "load": load, "accuracy": 0.01}
    assert steps(Case.model_validate({**entries, "lumen": solid})) == [(order, 1) for order in range(3, 7)]
    assert steps(Case.model_validate(entries))[0] == (2, 1)
