"""Rows of the tables of a run: one of an accepted step, one of a pair of facing walls, one of a cell.

The fields, in this order, are the columns of `history.csv`, `walls.csv` and `cells.csv`. A gap is positive where two
walls are apart and negative where they overlap; a contact pressure is never negative. Lengths have the unit of the
case's `side`, stresses that of its material constants; a planar scene is one unit of length deep.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan
from typing import Literal


@dataclass(frozen=True, slots=True)
class StepRecord:
    """One accepted step of a run: a row of `history.csv`.

    Attributes
    ----------
    step : int
        Number of the accepted step, from 0.
    phase : {"tied", "released"}
        Whether the walls are tied to one tied solid, or are free to part.
    load_factor : float
        Share of the case's full load, in [0, 1].
    plate_displacement : float
        Length of the displacement of the moved plate [length], >= 0; 0 under a load without a plate.
    largest_gap, mean_gap : float
        Normal gap over the walls between cells that something holds [length], open > 0; the mean is weighted by wall
        length in the reference state. Where a free cell sits is not determined by equilibrium.
    smallest_gap : float
        Smallest normal gap over all facing walls [length]; negative where they overlap.
    parted_pairs : int
        Number of wall pairs that are apart along the whole middle half of the wall.
    opened_share : float
        Share of the facing wall length, in the reference state, that is apart, in [0, 1]: by more than 1 % of the
        thickness of the thinner wall.
    components, largest_component : int
        Number of connected components of cells, joined by wall pairs that have not parted, and number of cells in the
        largest.
    plate_force_x, plate_force_y : float
        Force that the moved plate exerts on the tissue [stress * length**2], positive along the axis.
    contact_force : float
        Sum of the magnitudes of the forces between walls [stress * length**2], >= 0.
    energy : float
        Stored energy of all bodies [stress * length**3], >= 0.
    iterations, factorisations : int
        Newton iterations and matrix factorisations that this step took, cut-backs included.
    seconds : float
        Wall-clock time since the last accepted step [s].
    certified : bool
        Whether this step passed every check of the certificate.
    separation_energy : float
        Energy that the separation of bonded walls has consumed [stress * length**3], >= 0; 0 without cohesion.
    bonded_share : float
        Share of the bonded wall length whose traction has never reached the strength, in [0, 1]; 0 without bonds.
    dissipation : float
        Energy lost since the reference state where walls snapped apart or were released while the plates stood still
        [stress * length**3]; 0 without cohesion.
    plate_force_z : float
        As the other forces of the moved plate; 0 in a planar scene.
    free_largest_gap, free_mean_gap : float
        Gaps of the other walls, those of cells that nothing holds [length]; 0 where all cells are held.
    energy_error, plate_force_error, contact_force_error, mean_gap_error, largest_gap_error : float
        Estimated errors of the columns of these names, in their units; that of the plate force is of the vector. NaN
        where none was estimated.
    mean_gap_slid : float
        By how much the mean gap changed as walls were followed to where they rest, while the energy hardly changed
        [length], >= 0. Other places of rest may be as far from it, beyond its error. 0 where walls did not slide.
    more : mapping of str to float
        Further columns, by name: what terms and observables of the scene report.
    """

    step: int
    phase: Literal["tied", "released"]
    load_factor: float
    plate_displacement: float
    largest_gap: float
    mean_gap: float
    smallest_gap: float
    parted_pairs: int
    opened_share: float
    components: int
    largest_component: int
    plate_force_x: float
    plate_force_y: float
    contact_force: float
    energy: float
    iterations: int
    factorisations: int
    seconds: float
    certified: bool
    separation_energy: float = 0.0
    bonded_share: float = 0.0
    dissipation: float = 0.0
    plate_force_z: float = 0.0
    free_largest_gap: float = 0.0
    free_mean_gap: float = 0.0
    energy_error: float = nan
    plate_force_error: float = nan
    contact_force_error: float = nan
    mean_gap_error: float = nan
    largest_gap_error: float = nan
    mean_gap_slid: float = 0.0
    more: Mapping[str, float] = field(default_factory=dict)

    @property
    def place_on_path(self) -> float:
        """The plate displacement [length]; the load factor under a load that moves no plate."""
        return self.plate_displacement or self.load_factor


@dataclass(frozen=True, slots=True)
class WallRecord:
    """One pair of facing walls at one load level: a row of `walls.csv`.

    Attributes
    ----------
    step : int
        Number of the accepted step that the row belongs to.
    load_factor : float
        Share of the case's full load, in [0, 1].
    cell_a, cell_b : int
        Numbers of the two cells whose walls faced each other in the reference state.
    largest_gap, mean_gap : float
        Normal gap along the wall [length], open > 0; the mean is weighted by wall length in the reference state.
    force : float
        Magnitude of the force between the two walls [stress * length**2], >= 0.
    opened_share : float
        Share of the wall's reference length that is apart, in [0, 1]: by more than 1 % of the thinner wall's thickness.
    parted : bool
        Whether the walls are apart along the whole middle half of the wall.
    component : int
        Number of the connected component of cells that `cell_a` belongs to.
    onset : float
        Plate displacement [length], or load factor where no plate moves, at which the pair's mean gap first reached 5 %
        of the wall's thickness; NaN where it has not.
    normal_force : float
        Sum of the magnitudes of the normal contact forces between the two, wherever they touch
        [stress * length**2], >= 0.
    contact_pressure : float
        Mean contact pressure: the normal force over the deformed length on which `cell_a` is under more than a
        hundredth of its largest pressure from `cell_b` [stress], >= 0.
    """

    step: int
    load_factor: float
    cell_a: int
    cell_b: int
    largest_gap: float
    mean_gap: float
    force: float
    opened_share: float
    parted: bool
    component: int
    onset: float
    normal_force: float = 0.0
    contact_pressure: float = 0.0


@dataclass(frozen=True, slots=True)
class CellRecord:
    """One cell at one load level: a row of `cells.csv`.

    Attributes
    ----------
    step : int
        Number of the accepted step that the row belongs to.
    load_factor : float
        Share of the case's full load, in [0, 1].
    plate_displacement : float
        Length of the displacement of the moved plate [length], >= 0.
    cell : int
        Number of the cell: row by row, the lowest row first, from 0.
    pressure : float
        Pressure in the lumen [stress]: as prescribed, of the fluid as part of the solution, or the mean of the
        inclusion; 0 in an empty cell.
    component : int
        Number of the connected component of cells that it belongs to, joined by wall pairs that have not parted.
    component_size : int
        Number of cells in this component.
    held : bool
        Whether a support or a contact force holds the cell; one that floats has no place determined by equilibrium.
    more : mapping of str to float
        Further columns, by name: where it is known what walls bear, the `utilisation` of the cell's wall [1], the load
        factors `burst_at` and `separated_at`, NaN where they were not reached, and the energy that the cell stored
        where its wall ruptured, `burst_energy` [stress * length**3].
    """

    step: int
    load_factor: float
    plate_displacement: float
    cell: int
    pressure: float
    component: int
    component_size: int
    held: bool
    more: Mapping[str, float] = field(default_factory=dict)
