"""Contact by NGSolve's own contact boundary: its section in a case, its continuation stages, and its term.

NGSolve finds the pairs, sums the penalty energy over the quadrature points of both walls, and differentiates it:
energy, forces and tangent are NGSolve's. The package's own pairs at the same points tell the solver which part of them
is one-sided, so that it foresees where walls close; what is measured of an equilibrium and judged by the certificate
comes from them, too. The energies of both are compared: what NGSolve pairs otherwise is not certified.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.methods.ngsolve_boundary import BoundaryEnergy
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.methods.wall_strip import WallStrip, coloured
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach, near_facets
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import Surface
from ngcell.errors import CaseError
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.term import Configuration
from ngcell.scene.section import PositiveNumber, Section

Array = NDArray[np.float64]

#: Largest difference of the contact energies of NGSolve's pairs and of the package's own, over the energy at stake.
_APART = 1e-6


class NgsolveContact(Section):
    """Frictionless unilateral contact by `ngsolve.ContactBoundary`, with a penalty on the overlap, in the plane.

    Parameters
    ----------
    stiffness : float
        Multiple of the penalty stiffness that is derived from material, mesh and accuracy, > 0, without unit.
    """

    kind: Literal["ngsolve"] = "ngsolve"
    stiffness: PositiveNumber = 1.0
    goes_with_cohesion: ClassVar[bool] = True

    def stages(
        self, walls: Surface, modulus_of_body: Array, *, reach: Reach, options: ContactOptions = DEFAULT_OPTIONS
    ) -> tuple[NgsolveTerm, ...]:
        """Return penalties from the softest to the one that is meant; see `ngcell.contact.methods.stages`.

        Raises
        ------
        CaseError
            In three dimensions.
        """
        if not isinstance(walls, EdgeSurface):
            raise CaseError("contact.kind = 'ngsolve' in three dimensions; allowed: contact.kind = 'penalty', 'mortar'")
        meant = options.penalty_multiple * self.stiffness
        multiples = (*options.path_multiples(meant), meant)
        return tuple(NgsolveTerm(walls, penalty_stiffness(walls, modulus_of_body, each), reach) for each in multiples)


class NgsolveTerm(ContactTerm):
    """The penalty energy of NGSolve's contact boundaries.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    stiffness : array of float, shape (facets,)
        Penalty stiffness of each facet [stress / length]; a pair takes the softer one.
    reach : float or array of float, shape (bodies,)
        Distance up to which walls are paired [length].
    """

    def __init__(self, walls: EdgeSurface, stiffness: Array, reach: Reach) -> None:
        super().__init__(PenaltyContact(walls, stiffness, reach, may_stiffen=False))
        self._walls, self._reach = walls, reach
        self._colours = np.zeros(len(walls.thickness), dtype=np.int64)
        self._boundary: BoundaryEnergy | None = None
        self._stiff = self.stiffness
        self._found: tuple[Configuration, BoundaryEnergy] | None = None

    def _at(self, at: Configuration) -> BoundaryEnergy:
        """Return NGSolve's contact boundaries with the pairs of a configuration."""
        stiffness = self.stiffness
        if not np.array_equal(self._stiff, stiffness):  # the method has been made stiffer, or softer
            self._stiff, self._boundary, self._found = stiffness, None, None
        if self._found is None or self._found[0] is not at:
            boundary = self._coloured(self._walls.nodes(at.positions))
            boundary.find(at.positions)
            self._found = at, boundary
        return self._found[1]

    def _coloured(self, nodes: Array) -> BoundaryEnergy:
        """Return contact boundaries of colours that bodies near each other do not share."""
        one, two = (self._walls.body[facet] for facet in near_facets(self._walls, nodes, self._reach))
        if self._boundary is None or (self._colours[one] == self._colours[two]).any():
            self._colours = coloured(len(self._colours), one, two)
            strip = WallStrip(self._walls, self._colours)
            self._boundary = BoundaryEnergy(self._walls, strip, self._stiff, float(np.max(self._reach)))
        return self._boundary

    def value(self, at: Configuration) -> float:
        """Return NGSolve's energy."""
        return self._at(at).energy()

    def gradient(self, at: Configuration) -> Array:
        """Return the gradient of NGSolve's energy without that of the one-sided terms, shape (unknowns,)."""
        boundary = self._at(at)
        whole = boundary.map(at.positions.shape[1]).T @ boundary.gradient()
        return np.asarray(whole - self.constraints(at).gradient)

    def curvature(self, at: Configuration) -> sparse.coo_array:
        """Return NGSolve's tangent without that of the closed one-sided terms."""
        boundary, split = self._at(at), self.constraints(at)
        map_, closed = boundary.map(at.positions.shape[1]), split.gap < 0
        jacobian = split.jacobian[np.flatnonzero(closed)]
        along = jacobian.T @ sparse.diags_array(split.penalty[closed]) @ jacobian
        return (map_.T @ boundary.tangent() @ map_ - along).tocoo()

    def checks(self, at: Configuration, scales: Scales) -> tuple[Check, ...]:
        """Return what every contact is judged by, and by how much the package's own pairs store another energy."""
        apart = abs(self.value(at) - super().value(at)) / scales.at_stake
        meaning = "difference of contact energies by NGSolve's pairs and by the package's own over the stored energy"
        return (*super().checks(at, scales), Check("pairs_of_ngsolve", apart, _APART, meaning))
