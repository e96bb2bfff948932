"""What cells hold: cells under the same pressure share a boundary region and one term of the energy; what fills them
has a pressure, too."""

from __future__ import annotations

from dataclasses import dataclass

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import FILLING
from ngcell.geometry.tissues.protocol import TissueGeometry
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.space import DisplacementSpace
from ngcell.scene import CellPressure, Pressure

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Filling:
    """Regions of inner walls and the loads on them.

    Attributes
    ----------
    regions : dict of str to array of int
        Cells whose inner walls belong to each region.
    loads : tuple of Pressure
        Pressures on regions.
    pressure : array of float, shape (cells,)
        Pressure in each cell at load factor 1 [stress].
    """

    regions: dict[str, Index]
    loads: tuple[Pressure, ...]
    pressure: Array


def cell_pressures(lumen: CellPressure, tissue: TissueGeometry) -> Filling:
    """Return the pressures of all cells, which are numbered layer by layer and row by row, the lowest first."""
    pressure = np.broadcast_to(np.asarray(lumen.pressure, dtype=float), tissue.grid).ravel()
    values, group = np.unique(pressure, return_inverse=True)
    regions = {f"lumen{number}": np.flatnonzero(group == number) for number in range(len(values))}
    loads = (Pressure(name, float(value)) for name, value in zip(regions, values, strict=True) if value > 0)
    return Filling(regions, tuple(loads), pressure)


def filling_pressures(space: DisplacementSpace, law: HyperelasticLaw, displacement: Array) -> Array:
    """Return the mean pressure ``-trace(sigma) / 3`` in what fills each lumen [stress], shape (bodies,).

    The volumetric energy alone bears it: ``-kappa ln(J) / J``, averaged over the deformed area by the rule that this
    energy is integrated with.
    """
    bodies = space.bodies
    gradient = ngsolve.Id(space.dimension) + ngsolve.Grad(space.function(displacement))
    jacobian = ngsolve.Det(gradient)
    inside = ngsolve.dx(definedon=bodies.mesh.Materials(FILLING), intrules=reduced_rules(space))

    def by_body(density: ngsolve.CoefficientFunction) -> Array:
        values = np.array(ngsolve.Integrate(density * inside, bodies.mesh, element_wise=True))
        return np.bincount(bodies.body_of_element, values, bodies.body_count)

    return np.asarray(by_body(-law.bulk_modulus * ngsolve.log(jacobian)) / by_body(jacobian))


def reduced_rules(space: DisplacementSpace) -> dict[ngsolve.ET, ngsolve.IntegrationRule]:
    """Return the rules of the volumetric energy of what fills lumens: as many points in each direction as the order."""
    kind = ngsolve.ET.QUAD if space.dimension == 2 else ngsolve.ET.HEX
    return {kind: ngsolve.IntegrationRule(kind, 2 * space.order - 1)}
