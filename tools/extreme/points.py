"""All points of the map, those of them that are tried often, and those whose answer is perturbed.

Tissues of 2x2 or 3x3 cells and pairs of rings or blocks: a point takes seconds. Where a ring has an exact answer, the
radial balance of `tools.references.radial`, the case expects it.
"""

from __future__ import annotations

from dataclasses import replace

from tools.extreme import mechanics, numerics
from tools.extreme.perturbations import perturbations
from tools.extreme.point import Point

#: Points whose answer is perturbed.
STIFF: tuple[str, ...] = (
    "wall / side: 0.02, penalty",
    "bulk / shear: 1e+04 tissue, penalty",
    "bulk / shear: 1e+06 tissue, penalty",
    "inclusion / wall: 1e+04, penalty",
    "stiff neighbour: 1e-06 blocks, penalty",
    "stiff neighbour: 1e+06 press-fit, penalty",
    "c2 / c1: 100",
    "shear: 1 frame, penalty",
    "compression: 0.9 plates, penalty",
    "cell pressure: 0.98 of a ring's limit",
    "penalty: 1e+04 tissue",
    "overlap and gap: overlap 0.3, penalty",
    "mesh: graded to 0.01, penalty",
    "unequal sizes: 0.1 on 1, penalty",
)
#: Points of all kinds that take seconds.
QUICK: tuple[str, ...] = (
    "wall / side: 0.05, mortar",
    "wall / side: 0.5, penalty",
    "bulk / shear: 1e+00 tissue, penalty",
    "bulk / shear: 1e+06 tissue, penalty",
    "bulk / shear: 1e+02 press-fit, mortar",
    "inclusion / wall: 1e-04, penalty",
    "inclusion / wall: 1e+04, penalty",
    "stiff neighbour: 1e+06 blocks, penalty",
    "stiff neighbour: 1e+03 press-fit, penalty",
    "c2 / c1: 0",
    "c2 / c1: 100",
    "shear: 1 frame, penalty",
    "compression: 0.9 plates, penalty",
    "overlap and gap: gap 0.5, mortar",
    "compression: 0.75 frame, penalty",
    "cell pressure: 0.9 of a ring's limit",
    "cell pressure: tissue 0.02, penalty",
    "cell pressure: a pair of cells 2",
    "penalty: 1e-02 press-fit",
    "penalty: 1e+04 tissue",
    "penalty: 1e+06 press-fit",
    "units: m and Pa, penalty",
    "units: um and MPa, penalty",
    "units: km and GPa, penalty",
    "overlap and gap: overlap 0.01, mortar",
    "overlap and gap: overlap 0.4, mortar",
    "mesh: size 1, 1 layers, mortar",
    "mesh: size 0.5, 16 layers, penalty",
    "mesh: graded to 0.01, penalty",
    "unequal sizes: 0.1 on 1, penalty",
    "unequal sizes: 0.001 on 1, mortar",
    "steps: 1, sddp",
    "there and back: sddp, penalty",
    "prisms: planar",
    "prisms: height 1, held",
    "prisms: height 0.05",
    "prisms: bulk / shear 1e+04",
)


def points() -> list[Point]:
    """Return all points, in the order of the groups, and after them the stiff ones perturbed."""
    found = [point for group in (*mechanics.GROUPS, *numerics.GROUPS) for point in group()]
    found = [replace(point, is_quick=point.label in QUICK) for point in found]
    return found + [other for point in found if point.label in STIFF for other in perturbations(point)]
