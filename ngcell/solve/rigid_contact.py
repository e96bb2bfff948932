"""What rigid contact would change, told at a minimum by a finite penalty.

A penalty ``k`` leaves overlaps that fall as ``1 / k``. To first order in it, walls reach the state of rigid contact by
the displacement under their contact forces once more, with the tangent at the minimum: one step of the augmented
Lagrangian method (Bertsekas, Constrained Optimization and Lagrange Multiplier Methods, 1982, section 2.2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum

Array = NDArray[np.float64]


def toward_rigid_contact(minimiser: Minimiser, minimum: Minimum, weight: float) -> Array:
    """Return the displacement at which walls overlap by nothing, to first order, shape (unknowns,) [length].

    `weight` [stress / length**2] holds what would float else.
    """
    problem = minimiser.problem
    pressed = np.where(problem.free, problem.gradient_of_constraints(minimum.state), 0.0)
    return np.asarray(minimum.state.displacement - minimiser.stiffened(minimum, weight)(pressed))
