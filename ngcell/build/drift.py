"""Bodies that a load drives away for good: told before anything is solved, since the energy has no lowest value.

A body without support that a load pushes moves on along the push until another one is in its way. If that has no
support either, both move on. Where nothing that is held is ever in the way, nothing balances the load: there is no
equilibrium, and a minimisation would follow the body for ever.

A body is not in the way if there is a plane with it below and the other one above, and the push leads no deeper: with
that one moving on, they stay apart. Bodies without such a plane, among those that are tried, may be in the way, and
are left to the solver.
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
#: Number of directions that are tried besides the axes and the push itself.
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
    push = space.resultants(nodal.ravel())
    least = _NOTHING * float(np.abs(nodal).sum())
    is_pushed = ~is_held & (np.linalg.norm(push, axis=1) > least)
    travel = np.abs(motion.imposed(np.zeros(space.unknowns), 1.0)).max() if is_pushed.any() else 0.0
    for body in np.flatnonzero(is_pushed):
        # Others that are pushed may push this one, wherever they touch it.
        holds = is_held | is_pushed
        holds[body] = False
        spare = np.where(is_held, travel, space.bodies.length) - _APART * space.bodies.thickness
        if not (_swept_up(space, int(body), push[body], spare) & holds).any():
            force = ", ".join(f"{component:.4g}" for component in push[body])
            raise CaseError(
                f"loads: {space.bodies.body_names[body]} has no support, and its load ({force}) drives it to where "
                "nothing can hold it; allowed: a support of it, a body that is held in its way, or loads that balance"
            )


def _swept_up(space: DisplacementSpace, first: int, push: Array, spare: Array) -> NDArray[np.bool_]:
    """Return which bodies may be in the way of one that is pushed, or of those that it takes along."""
    normals, vertices = _normals(push), space.one == 1
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


def _normals(push: Array) -> Array:
    """Return unit normals of planes that a body on their upper side does not cross as it moves on."""
    along = push / np.linalg.norm(push)
    across = np.linalg.svd(along[None])[2][1:]
    drawn = np.random.default_rng(0).standard_normal((_DRAWN, len(push)))
    axes = np.concatenate([np.eye(len(push)), -np.eye(len(push)), drawn])
    upward = axes[axes @ along >= 0]
    return np.concatenate([along[None], across, -across, upward / np.linalg.norm(upward, axis=1)[:, None]])
