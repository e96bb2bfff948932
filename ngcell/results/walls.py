"""What is reported of each pair of facing walls, and which cells are still joined by them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.geometry.near import components
from ngcell.results.equilibrium import OPEN
from ngcell.results.measure import Measurement
from ngcell.results.record import WallRecord

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CellComponents:
    """Connected components of cells: those that walls which have not parted join.

    Attributes
    ----------
    of_body : array of int, shape (bodies,)
        Component that each body belongs to.
    sizes : array of int, shape (components,)
        Number of bodies of each component.
    """

    of_body: NDArray[np.int64]
    sizes: NDArray[np.int64]


def pair_gaps(facing: FacingWalls, gap: Array) -> Array:
    """Return the mean gap of each facing pair [length], from that of all points."""
    count = len(facing.pairs)
    length = np.bincount(facing.pair, facing.weight, count)
    return np.bincount(facing.pair, facing.weight * gap, count) / length


def _is_open(facing: FacingWalls, gap: Array) -> NDArray[np.bool_]:
    """Return which points are open, beside the thickness of the thinner of the two bodies."""
    return np.asarray(gap > OPEN * facing.thickness[facing.pair])


def opened_share(facing: FacingWalls, gap: Array) -> float:
    """Return the share of the facing wall length that is open, in [0, 1]."""
    return float(facing.weight @ _is_open(facing, gap) / max(facing.weight.sum(), np.finfo(float).tiny))


def parted_pairs(facing: FacingWalls, gap: Array) -> NDArray[np.bool_]:
    """Return which facing pairs are apart along the whole middle half of the wall, shape (pairs,)."""
    closed = facing.is_middle & ~_is_open(facing, gap)
    return np.asarray(np.bincount(facing.pair[closed], minlength=len(facing.pairs)) == 0)


def find_components(facing: FacingWalls, parted: NDArray[np.bool_], bodies: int) -> CellComponents:
    """Return the components of so many bodies, whose facing pairs have parted or not."""
    joined = facing.pairs[~parted]
    component = components(bodies, joined[:, 0], joined[:, 1])
    return CellComponents(component, np.bincount(component))


def wall_records(
    facing: FacingWalls, measured: Measurement, step: int, onset: Array, pressed: Array
) -> list[WallRecord]:
    """Return a row for each facing pair of a step; `onset` is where each has opened, shape (pairs,).

    `pressed` is the deformed length on which the pair is in contact [length], shape (pairs,).
    """
    count = len(facing.pairs)
    largest = np.full(count, -np.inf)
    np.maximum.at(largest, facing.pair, measured.gap)
    length = np.bincount(facing.pair, facing.weight, count)
    mean = pair_gaps(facing, measured.gap)
    share = np.bincount(facing.pair, facing.weight * _is_open(facing, measured.gap), count) / length
    parted = parted_pairs(facing, measured.gap)
    component = find_components(facing, parted, len(measured.forces.on_body)).of_body
    force, normal = measured.forces.between(facing.pairs), measured.forces.normal_between(facing.pairs)
    pressure = np.divide(normal, pressed, out=np.zeros(count), where=pressed > 0)
    return [
        WallRecord(
            step=step,
            load_factor=measured.load_factor,
            cell_a=int(one),
            cell_b=int(two),
            largest_gap=float(largest[pair]),
            mean_gap=float(mean[pair]),
            force=float(force[pair]),
            opened_share=float(share[pair]),
            parted=bool(parted[pair]),
            component=int(component[one]),
            onset=float(onset[pair]),
            normal_force=float(normal[pair]),
            contact_pressure=float(pressure[pair]),
        )
        for pair, (one, two) in enumerate(facing.pairs)
    ]
