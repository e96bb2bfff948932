"""Other programs on blocks and rings: named where they are not installed, right where they are."""

from __future__ import annotations

import pytest

from tools.references.peers import calculix, here, missing, with_getfem
from tools.references.peers.problems import exact_force


def test_what_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr(calculix.shutil, "which", lambda name: None)
    monkeypatch.setattr(with_getfem, "_python", lambda: "")
    assert [line.split(":")[0] for line in missing()] == ["CalculiX", "GetFEM"]


@pytest.mark.parametrize("peer", [calculix, with_getfem])
@pytest.mark.parametrize(("problem", "error"), [("blocks", 0.01), ("rings", 2e-3)])
def test_peers_solve_what_is_meant(peer, problem, error):
    if peer.missing():
        pytest.skip(peer.missing())
    force, _, _ = peer.force(problem, 4, 2)
    assert force == pytest.approx(exact_force(problem, in_logarithm=False), rel=error)


@pytest.mark.parametrize("method", here.METHODS)
@pytest.mark.parametrize(("problem", "error"), [("blocks", 3e-3), ("rings", 1e-3)])
def test_this_package_solves_the_same(method, problem, error):
    force, _, _ = here.force(method, problem, 4, 2)
    assert force == pytest.approx(exact_force(problem, in_logarithm=True), rel=error)
