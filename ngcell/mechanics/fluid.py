"""An incompressible fluid in each lumen: its area, in three dimensions its volume, stays what it is told, and its
pressure is part of the answer.

The area of a lumen is half the integral of ``x cross dx`` around it, hence a quadratic function of the displacement;
the volume of a closed lumen in three dimensions is a cubic one. Both are called area here.

With c the area less what the fluid needs, and A that at rest, the energy

    sum of (A / 2 r) ((p - r c / A)^2 - p^2)  =  sum of -p c + r c^2 / 2 A

is that of a liquid of bulk modulus r under the pressure p. It is minimised at fixed p; then p becomes the pressure
``p - r c / A`` that the liquid answers with, until no area is off (the method of multipliers). The modulus only sets
the pace. Each lumen adds a full block over the unknowns of its outline to the tangent, of rank one but for what p adds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.applied.boundary_pressure import Pressure
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.drive import Drive
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Configuration, Role, Term

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Largest relative deviation of an area that the certificate passes.
LUMEN_AREA = 1e-8
_MEANING = "largest deviation of a lumen's area or volume from that of its fluid, relative; fluids only"
#: By how much the liquid is stiffened where updates are slow, and at most in all.
PENALTY_INCREASE, MOST_INCREASE = 10.0, 1e4


class LumenFluids(Term):
    """The fluids of all cells of a tissue.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    region : str
        Boundary region of the lumens, a regular expression: one closed line, in three dimensions one closed surface, in
        each body that has a lumen.
    modulus : float
        Bulk modulus r of the liquid that stands for the fluid along the way [stress], > 0.
    fill : float
        Area of the fluid at load factor 1 over that of the lumen at rest, > 0.
    in_full : bool
        Whether cells hold that much at every load factor, instead of being filled as the load grows.

    Attributes
    ----------
    area : array of float, shape (lumens,)
        Areas at rest [length**dimension].
    body : array of int, shape (lumens,)
        Body of each lumen.
    pressure : array of float, shape (lumens,)
        Pressure p of each fluid, as far as it is known [stress].
    """

    def __init__(
        self, space: DisplacementSpace, region: str, *, modulus: float, fill: float = 1.0, in_full: bool = False
    ) -> None:
        outline = space.region_unknowns(region)
        self.body = np.unique(space.body_of_unknown[outline])
        self._member = np.concatenate([axis * space.size + outline for axis in range(space.dimension)])
        lumen = np.searchsorted(self.body, space.body_of_unknown[outline])
        self._lumen = np.tile(lumen, space.dimension)
        self._swept = (_Outlines if space.dimension == 2 else _Surfaces)(space, region, self._member)
        self._size, self._dimension, self._bodies = space.unknowns, space.dimension, space.body_count
        self._modulus, self._fill, self._in_full = modulus, fill, in_full
        # Bodies are blown up to twice their size.
        self.area = self._risen(space.rest.ravel()) / (2**space.dimension - 1)
        self._pairs()
        self.apply(0.0)

    def _pairs(self) -> None:
        """List all pairs of unknowns of each lumen, the lower triangle, and which of them have a second derivative."""
        row, column = [], []
        for lumen in range(len(self.area)):
            mine = np.flatnonzero(self._lumen == lumen)
            one, two = np.tril_indices(len(mine))
            row.append(mine[one])
            column.append(mine[two])
        self._row, self._column = np.concatenate(row), np.concatenate(column)
        bent = self._swept.pattern
        width = len(self._member)
        order = np.argsort(self._row * width + self._column)
        found = np.searchsorted((self._row * width + self._column)[order], bent[0] * width + bent[1])
        self._bent = order[found]

    def apply(self, load_factor: float) -> None:
        """Set the load factor, and forget what was updated about pressures."""
        self._share = self.share(load_factor)
        self._pace = 1.0
        self.pressure = np.zeros(len(self.area))

    def share(self, load_factor: float) -> float:
        """Return the share of the filling that is in at a load factor."""
        return 1.0 if self._in_full else load_factor

    @property
    def keeps_lumens_open(self) -> bool:
        """A lumen keeps the area that its fluid has."""
        return True

    @property
    def needed(self) -> Array:
        """Area of each fluid [length**dimension], shape (lumens,)."""
        return np.asarray((1 + self._share * (self._fill - 1)) * self.area)

    def areas(self, displacement: Array) -> Array:
        """Return the area of each lumen [length**dimension], shape (lumens,)."""
        return np.asarray(self.area + self._risen(displacement))

    def pressures(self, displacement: Array) -> Array:
        """Return the pressure that each liquid answers with [stress], shape (lumens,)."""
        return self.pressure - self._stiffness * self._surplus(displacement)

    @property
    def role(self) -> Role:
        """What cells hold acts on their walls."""
        return Role.LOAD

    def value(self, at: Configuration) -> float:
        """Return the energy of the liquids [stress * length**dimension]; 0 where all areas are right."""
        difference = self.pressures(at.displacement) ** 2 - self.pressure**2
        return float((difference / (2 * self._stiffness)).sum())

    def unstored(self, at: Configuration) -> float:
        """Return the energy of the liquids: the fluids that they stand for store none."""
        return self.value(at)

    def drive(self, at: Configuration, load_factor: float) -> Drive:
        """Return the share that is filled in, and the work against the pressures for each unit of it."""
        return Drive(self.share(load_factor), 0.0, self.filling_rate(at.displacement))

    def cell_fields(self, at: Configuration, load_factor: float) -> dict[str, Array]:
        """Return the pressure in each cell [stress], 0 in cells without a lumen."""
        pressure = np.zeros(self._bodies)
        pressure[self.body] = self.pressures(at.displacement)
        return {"cell_pressure": pressure}

    def checks(self, at: Configuration, scales: Scales) -> tuple[Check, ...]:
        """Return the largest deviation of an area."""
        return (Check("lumen_area", self.missed(at.displacement), LUMEN_AREA, _MEANING),)

    def gradient(self, at: Configuration) -> Array:
        """Return minus the nodal forces on the walls [stress * length], shape (unknowns,)."""
        displacement = at.displacement
        slope = np.zeros(self._size)
        slope[self._member] = -self.pressures(displacement)[self._lumen] * self._swept.slope(displacement)
        return slope

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `tangent` fills, without repetitions."""
        row, column = self._member[self._row], self._member[self._column]
        return np.maximum(row, column), np.minimum(row, column)

    def tangent(self, at: Configuration) -> Array:
        """Return the second derivative of the energy [stress] on `pattern`."""
        displacement, lumen = at.displacement, self._lumen[self._row]
        rise = self._swept.slope(displacement)
        squeeze = self._stiffness[lumen] * rise[self._row] * rise[self._column]
        bent = np.zeros(len(squeeze))
        bent[self._bent] = self._swept.bend(displacement)
        return np.asarray(squeeze - self.pressures(displacement)[lumen] * bent)

    def missed(self, displacement: Array) -> float:
        """Return the largest relative deviation of an area from that of its fluid."""
        return float(np.abs(self._surplus(displacement) / self.needed).max(initial=0.0))

    def filling_rate(self, displacement: Array) -> float:
        """Return the work against the pressures for each unit of the share that is filled in [stress * length**2]."""
        return float((self._fill - 1) * (self.pressures(displacement) @ self.area))

    def refine(self, coarse: Term, at: Configuration) -> None:
        """Take over the pressures."""
        assert isinstance(coarse, LumenFluids)
        self.pressure = coarse.pressures(at.displacement)

    def update_multipliers(self, at: Configuration, stored: StoredEnergy) -> tuple[float, float]:
        """Take over the pressures of an equilibrium; return by how much areas were off, as a length [length], and the
        energy of that in the liquids [stress * length**2]."""
        surplus = self._surplus(at.displacement)
        self.pressure = self.pressures(at.displacement)
        energy = float((self._stiffness * surplus**2).sum()) / 2
        surface = self.area ** (1 - 1 / self._dimension)
        return float(np.abs(surplus / surface).max(initial=0.0)), energy

    def increase_penalty(self) -> None:
        """Stiffen the liquids: where cells are confined, they are stiffer than these were made for."""
        self._pace = min(PENALTY_INCREASE * self._pace, MOST_INCREASE)

    @property
    def _stiffness(self) -> Array:
        """Pressure for each surplus of area [stress / length**dimension], shape (lumens,)."""
        return np.asarray(self._pace * self._modulus / self.area)

    def _surplus(self, displacement: Array) -> Array:
        return np.asarray(self.areas(displacement) - self.needed)

    def _risen(self, displacement: Array) -> Array:
        """Return the change of each lumen's area."""
        return np.asarray(np.bincount(self._lumen, self._swept.shares(displacement), len(self.body)), dtype=float)


class _Outlines:
    """Areas within lines, quadratic in the displacement.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    region : str
        The closed lines, a regular expression.
    member : array of int, shape (members,)
        Their unknowns.

    Attributes
    ----------
    pattern : tuple of array of int
        Rows and columns among the members of the entries of the second derivative, lower triangle.
    """

    def __init__(self, space: DisplacementSpace, region: str, member: Index) -> None:
        rest, swept = np.zeros(space.unknowns), _unit_pressure(space, region)
        self._member = member
        self._slope = -swept.gradient(space.configuration(rest))[member]
        self._bend = -swept.form.tangent(rest)[member][:, member].tocsr()
        lower = sparse.tril(self._bend).tocoo()
        self.pattern, self._lower = lower.coords, lower.data

    def shares(self, displacement: Array) -> Array:
        """Return what members contribute to the change of areas, shape (members,)."""
        by = displacement[self._member]
        return np.asarray(by * (self._slope + self._bend @ by / 2))

    def slope(self, displacement: Array) -> Array:
        """Return the derivative of the areas by the members, shape (members,)."""
        return np.asarray(self._slope + self._bend @ displacement[self._member])

    def bend(self, displacement: Array) -> Array:
        """Return the second derivative on `pattern`."""
        return np.asarray(self._lower)


class _Surfaces:
    """Volumes within surfaces, homogeneous of degree three in positions; parameters and attributes as for `_Outlines`.

    By Euler's theorem they are a third of positions times derivatives.
    """

    def __init__(self, space: DisplacementSpace, region: str, member: Index) -> None:
        self._space, self._swept = space, _unit_pressure(space, region)
        self._member, self._rest = member, space.rest.ravel()[member]
        nothing = np.zeros(space.unknowns)
        self._at_rest = self._rest * self.slope(nothing)
        tangent = self._swept.form.tangent(nothing)
        row, column = np.repeat(np.arange(space.unknowns), np.diff(tangent.indptr)), tangent.indices
        place = np.full(space.unknowns, -1)
        place[member] = np.arange(len(member))
        row, column = place[row], place[column]
        self._lower = np.flatnonzero((row >= 0) & (column >= 0) & (row >= column))
        self.pattern = row[self._lower], column[self._lower]

    def shares(self, displacement: Array) -> Array:
        """Return what members contribute to the change of volumes, shape (members,)."""
        moved = (self._rest + displacement[self._member]) * self.slope(displacement)
        return np.asarray((moved - self._at_rest) / 3)

    def slope(self, displacement: Array) -> Array:
        """Return the derivative of the volumes by the members, shape (members,)."""
        return np.asarray(-self._swept.gradient(self._space.configuration(displacement))[self._member])

    def bend(self, displacement: Array) -> Array:
        """Return the second derivative on `pattern`."""
        return np.asarray(-self._swept.form.tangent(displacement).data[self._lower])


def _unit_pressure(space: DisplacementSpace, region: str) -> AppliedLoads:
    """Return a unit pressure, whose potential is what the boundary sweeps out of the lumen."""
    loads = AppliedLoads(space, [Pressure(boundary=region, value=1.0)], PrescribedMotion(space, []))
    loads.apply(1.0)
    return loads
