"""Grids of settings of the shipped cases: what `settings` runs.

scenes-3x3, scenes-5x7
    Strategy, wall, edges to a side, order and corner radius: all of them together, or one at a time.
steps
    Both strategies with different numbers of levels.
penalty
    The contact's stiffness.
far
    The plates moved by half of the tissue's height.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from ngcell import MeshChoice, Tissue

FOLDERS = Path(tempfile.gettempdir()) / "ngcell-settings"


@dataclass(frozen=True)
class Setting:
    """A shipped case and what is set in it.

    Attributes
    ----------
    case : str
        Name of the case.
    overrides : tuple of str
        Each ``key=value``.
    """

    case: str
    overrides: tuple[str, ...]

    @property
    def label(self) -> str:
        """The row's key."""
        return " ".join((self.case, *self.overrides))

    @property
    def folder(self) -> Path:
        """Where its results are kept."""
        name = "".join(letter if letter.isalnum() or letter in ".=-" else "_" for letter in self.label)
        return FOLDERS / name

    @property
    def log(self) -> Path:
        """Where its log is kept."""
        return FOLDERS / f"{self.folder.name}.log"


def default_edges(wall: float) -> int:
    """Return the default number of edges to a side of length 1."""
    return Tissue(rows=1, cols=1, wall=wall).density(MeshChoice())[0]


def _scene(
    case: str, strategy: str, wall: float, finer: int, order: int, radius: float, levels: str = "[1.0]"
) -> Setting:
    size = () if finer == 1 else (f"mesh.size={1 / (finer * default_edges(wall)):.6g}",)
    return Setting(
        case,
        (
            f"load.levels={levels}",
            f'strategy.kind="{strategy}"',
            f"tissue.wall={wall}",
            f"mesh.order={order}",
            f"tissue.corner_radius={radius}",
            *size,
        ),
    )


def scenes_3x3(quick: bool) -> Iterator[Setting]:
    """All settings together; the finest of them at sharp corners only."""
    walls, orders = ((0.1,), (2, 3)) if quick else ((0.05, 0.1, 0.2), (1, 2, 3, 4))
    for radius, finer, order, wall, strategy in product((0.0, 0.1), (1, 2), orders, walls, ("sddp", "single-step")):
        if not (radius and finer == 2 and order > 2):
            yield _scene("shear-empty-3x3", strategy, wall, finer, order, radius)


def scenes_5x7(quick: bool) -> Iterator[Setting]:
    """Both strategies, then one setting changed at a time."""
    usual = {"strategy": "sddp", "wall": 0.1, "finer": 1, "order": 3, "radius": 0.0}
    changes: list[dict[str, Any]] = [{}, {"strategy": "single-step"}]
    if not quick:
        changes += [{"wall": 0.05}, {"wall": 0.2}, {"finer": 2}, {"order": 1}, {"order": 2}, {"radius": 0.1}]
    for change in changes:
        yield _scene("shear-empty", **{**usual, **change})


def steps(quick: bool) -> Iterator[Setting]:
    """Both strategies with more and more levels."""
    cases = {"shear-empty-3x3": (5, 10, 20)} if quick else {"shear-empty-3x3": (5, 10, 20), "shear-empty": (5, 10)}
    for case, counts in cases.items():
        for count, strategy in product(counts, ("sddp", "single-step")):
            yield Setting(case, (f"load.levels={count}", f'strategy.kind="{strategy}"'))


def penalty(quick: bool) -> Iterator[Setting]:
    """The contact's stiffness."""
    for multiple in (0.3, 1.0, 3.0) if quick else (0.1, 0.3, 1.0, 3.0, 10.0, 30.0):
        yield Setting("shear-empty-3x3", ("load.levels=[1.0]", f"contact.stiffness={multiple}"))


def far(quick: bool) -> Iterator[Setting]:
    """Half of the tissue's height."""
    if quick:
        yield Setting("shear-empty-3x3", ("load.displacement=[2.5,0.0]", "load.levels=5"))
    else:
        yield Setting("shear-empty", ("load.displacement=[4.0,0.0]", "load.levels=10"))


GRIDS = {
    "scenes-3x3": scenes_3x3, "scenes-5x7": scenes_5x7, "steps": steps, "penalty": penalty, "far": far,
}  # fmt: skip
