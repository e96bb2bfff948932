"""Bodies that a load drives away for good: told before anything is solved, since the energy has no lowest value.

A body without support moves on along the sum of its loads until another one is in its way. If that has no
support either, both move on. Where nothing that is held is ever in the way, nothing balances the load: there is no
equilibrium, and a minimisation would follow the body for ever.

A plane tells that another body is not in the way: that one lies below it, the one that moves on lies above it, and the
force leads no deeper. Where no such plane is found among those that are tried, a body may be in the way, and the scene
is left to the solver.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ngcell.build.balance import load_at_rest
from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Term

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of all nodal forces that is the round-off of their sum, and overlap across a plane, as a share of the thickness
#: of the thinnest body, that is that of curved boundaries.
_NOTHING, _APART = 1e-6, 1e-3
#: Number of directions that are tried besides the axes and the force itself.
_DRAWN = 200


def check_nothing_drifts(space: DisplacementSpace, terms: Sequence[Term], motion: PrescribedMotion) -> None:
    """Check that no load drives a body without support to where nothing can hold it.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    terms : sequence of Term
        All terms of the energy.
    motion : PrescribedMotion
        The supports.

    Raises
    ------
    CaseError
        If one does.
    """
    is_held = np.zeros(space.body_count, dtype=bool)
    is_held[space.body_of_unknown[motion.fixed.any(0)]] = True
    if is_held.all():
        return
    nodal = load_at_rest(space, terms)
    force = space.resultants(nodal.ravel())
    least = _NOTHING * float(np.abs(nodal).sum())
    is_driven = ~is_held & (np.linalg.norm(force, axis=1) > least)
    prescribed = np.abs(motion.imposed(np.zeros(space.unknowns), 1.0)).max() if is_driven.any() else 0.0
    for body in np.flatnonzero(is_driven):
        # Others that are driven may press on this one, wherever they touch it.
        holds = is_held | is_driven
        holds[body] = False
        spare = np.where(is_held, prescribed, space.bodies.length) - _APART * space.bodies.thickness
        if not (_swept_up(space, int(body), force[body], spare) & holds).any():
            load = ", ".join(f"{component:.4g}" for component in force[body])
            raise CaseError(
                f"loads: {space.bodies.body_names[body]} has no support, and its load ({load}) drives it to where "
                "nothing can hold it; allowed: a support of it, a body that is held in its way, or loads that balance"
            )


def _swept_up(space: DisplacementSpace, first: int, force: Array, spare: Array) -> NDArray[np.bool_]:
    """Return which bodies may be in the way of one that is driven, or of those that it takes along."""
    normals, vertices = _normals(force), space.one == 1
    height, body = (normals @ space.rest[:, vertices]).T, space.body_of_unknown[vertices]
    low, depth = np.full((2, space.body_count, len(normals)), np.inf)
    np.minimum.at(low, body, height)
    np.minimum.at(depth, body, -height)
    taken = np.arange(space.body_count) == first
    while True:
        is_below = low[taken] >= (spare[:, None] - depth)[:, None]
        more = taken | ~is_below.any(2).all(1)
        if np.array_equal(more, taken):
            return np.asarray(more)
        taken = more


def _normals(force: Array) -> Array:
    """Return unit normals of planes that a body on their upper side does not cross as it moves on."""
    along = force / np.linalg.norm(force)
    across = np.linalg.svd(along[None])[2][1:]
    drawn = np.random.default_rng(0).standard_normal((_DRAWN, len(force)))
    axes = np.concatenate([np.eye(len(force)), -np.eye(len(force)), drawn])
    upward = axes[axes @ along >= 0]
    return np.concatenate([along[None], across, -across, upward / np.linalg.norm(upward, axis=1)[:, None]])
