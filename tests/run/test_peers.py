"""Other programs on blocks, rings and seven cells: named where they are not installed, right where they are."""

from __future__ import annotations

import numpy as np
import pytest

from tools.references.peers import calculix, here, rows, with_getfem
from tools.references.peers.problems import MOTION, exact_force, problem


def test_what_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr(calculix.shutil, "which", lambda name: None)
    monkeypatch.setattr(with_getfem, "_python", lambda: "")
    assert [line.split(":")[0] for line in rows.missing()] == ["CalculiX", "GetFEM"]


@pytest.mark.parametrize("peer", [calculix, with_getfem])
@pytest.mark.parametrize(("name", "error"), [("blocks", 0.01), ("rings", 2e-3)])
def test_peers_solve_what_is_meant(peer, name, error):
    if peer.missing():
        pytest.skip(peer.missing())
    found = peer.solve(problem(name, 4), 2)
    assert found.force == pytest.approx(exact_force(name, in_logarithm=False), rel=error)


@pytest.mark.parametrize("method", here.METHODS)
@pytest.mark.parametrize(("name", "error"), [("blocks", 3e-3), ("rings", 1e-3)])
def test_this_package_solves_the_same(method, name, error):
    found = here.solve(method, problem(name, 4), 2)
    assert found.force == pytest.approx(exact_force(name, in_logarithm=True), rel=error)


@pytest.mark.parametrize("peer", [calculix, with_getfem])
def test_peers_find_the_seven_cells_of_this_package(peer):
    if peer.missing():
        pytest.skip(peer.missing())
    cells = problem("cells", 1)
    found, here_found = peer.solve(cells, 2), here.solve("penalty", cells, 3)
    assert (found.force, found.opening) == pytest.approx((here_found.force, here_found.opening), rel=0.1)


def test_every_two_neighbours_among_seven_cells_are_one_pair_of_walls_that_face_each_other():
    cells = problem("cells", 1)
    assert len({frozenset((pair.first[0], pair.second[0])) for pair in cells.pairs}) == len(cells.pairs) == 12
    for pair in cells.pairs:
        bodies = [(cells.bodies[body], side) for body, side in (pair.first, pair.second)]
        one, two = (body.places[body.sides[side]] for body, side in bodies)
        np.testing.assert_allclose(one, two[::-1], atol=1e-12)


def test_the_deck_of_seven_cells_has_its_pairs_and_supports():
    cards = _cards(calculix.deck(problem("cells", 1), 2)[0])
    nodes = {int(node): np.array([float(x) for x in at[:2]]) for _, lines in cards["*NODE"] for node, *at in lines}
    faces = {options["NAME"]: lines for options, lines in cards["*SURFACE"]}
    pairs = [lines[0] for _, lines in cards["*CONTACT PAIR"]]
    assert len(pairs) == 12
    for dependent, other in pairs:
        assert len(faces[dependent]) == len(faces[other]) == 4
    held, moved = (lines for _, lines in cards["*BOUNDARY"])
    assert held == [[f"N-CELL{number}", "3", "3"] for number in range(7)]
    # Outer cells are held along 16 elements: 33 nodes below and above, 17 half-way up.
    assert len(moved) == 6 * 83 * 2
    for node, axis, _, value in moved:
        place = nodes[int(node)]
        assert np.linalg.norm(place) > np.sqrt(3)
        assert float(value) == pytest.approx(np.dot(MOTION[int(axis) - 1], place), abs=1e-11)


def test_no_number_of_a_deck_is_longer_than_what_calculix_reads():
    deck, _ = calculix.deck(problem("cells", 2), 2)
    assert max(len(word.strip()) for line in deck.splitlines() if line[0] != "*" for word in line.split(",")) <= 20


def test_errors_of_cells_are_told_against_the_reference():
    right = {"problem": "cells", "program": rows.REFERENCE, "force": "2", "opening": "0.5", "error": "0.0e+00"}
    failed = right | {"program": "GetFEM", "force": "", "opening": "", "error": "no convergence"}
    found = rows.judged([right, right | {"program": "CalculiX", "force": "3"}, failed])
    assert [(row["error"], row["opening error"]) for row in found] == [
        ("", ""),
        ("5.0e-01", "0.0e+00"),
        ("no convergence", ""),
    ]


def test_rows_of_runs_that_are_not_repeated_stay():
    one, two = ({"problem": "cells", "program": "GetFEM", "order": "1", "elements across": n} for n in "12")
    table = rows.merged([one | {"force": "1"}, two | {"force": "2"}], [two | {"force": "3"}])
    assert [row["force"] for row in table] == ["1", "3"]


def _cards(deck):
    """Return the options of each card of a deck, and the words of its lines, by keyword."""
    cards = {}
    for line in deck.splitlines():
        words = [word.strip() for word in line.strip(",").split(",")]
        if line.startswith("*"):
            options = dict(word.partition("=")[::2] for word in words[1:])
            cards.setdefault(words[0], []).append((options, []))
            last = cards[words[0]][-1][1]
        else:
            last.append(words)
    return cards
