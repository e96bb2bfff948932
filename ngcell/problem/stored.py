"""What the terms of a problem store, body by body."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.term import Configuration, Role, Term


def stored_by(terms: Iterable[Term], at: Configuration, body_count: int) -> tuple[NDArray[np.float64], float]:
    """Return what is stored in each body, shape (bodies,), and what belongs to none [energy]; what acts between bodies
    does not count."""
    in_bodies, beside = np.zeros(body_count), 0.0
    for term in terms:
        mine = term.stored_in_bodies(at)
        if mine is not None:
            in_bodies += mine
        elif term.role is not Role.INTERACTION:
            beside += term.value(at) - term.unstored(at)
    return in_bodies, beside
