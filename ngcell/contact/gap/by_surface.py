"""Which gap a surface has: that of edges, or that of faces."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.edge_gap import EdgeGap, edge_kinematics
from ngcell.contact.gap.facet_gap import FacetGap, facet_kinematics
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
def gap_of(walls: Surface) -> Gap:
    """Return what the gap to a surface is."""
    raise NotImplementedError(type(walls))


gap_kinematics.register(EdgeSurface, edge_kinematics)
gap_kinematics.register(FacetSurface, facet_kinematics)
gap_of.register(EdgeSurface, lambda walls: EdgeGap())
gap_of.register(FacetSurface, lambda walls: FacetGap())
