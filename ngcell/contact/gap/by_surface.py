"""Which gap a surface has: that of edges, or that of faces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, singledispatch

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.beside_corners import Corners
from ngcell.contact.gap.edge_gap import EdgeGap, edge_kinematics
from ngcell.contact.gap.facet_gap import FacetGap, facet_kinematics
from ngcell.contact.gap.joints_ahead import joints_ahead
from ngcell.contact.gap.kinematics import Gap, GapKinematics
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface


@singledispatch
def gap_kinematics(walls: Surface, pairs: ContactPairs, positions: NDArray[np.float64]) -> GapKinematics:
    """Return the kinematics of contact pairs that were found at `positions`, shape (dimension, scalar unknowns)."""
    raise NotImplementedError(type(walls))


@singledispatch
def single_pass_kinematics(
    walls: Surface,
) -> Callable[[ContactPairs, NDArray[np.float64]], GapKinematics]:
    """Return what makes the kinematics of contact pairs that count next to corners on the corner's wall alone.

    Faces have both passes everywhere.
    """
    raise NotImplementedError(type(walls))


@singledispatch
def gap_of(walls: Surface) -> Gap:
    """Return what the gap to a surface is."""
    raise NotImplementedError(type(walls))


@singledispatch
def joints_pressed_over(
    walls: Surface,
    before: GapKinematics,
    place: NDArray[np.int64],
    after: GapKinematics,
    positions: NDArray[np.float64],
    moved: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], sparse.csr_array] | None:
    """Return what `ngcell.contact.gap.joints_ahead` does; None of faces."""
    raise NotImplementedError(type(walls))


gap_kinematics.register(EdgeSurface, edge_kinematics)
gap_kinematics.register(FacetSurface, facet_kinematics)
single_pass_kinematics.register(EdgeSurface, lambda walls: Corners(walls).kinematics)
single_pass_kinematics.register(FacetSurface, lambda walls: partial(gap_kinematics, walls))
joints_pressed_over.register(EdgeSurface, joints_ahead)
joints_pressed_over.register(FacetSurface, lambda *_: None)
gap_of.register(EdgeSurface, lambda walls: EdgeGap())
gap_of.register(FacetSurface, lambda walls: FacetGap())
