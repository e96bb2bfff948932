"""Members of a case: the same scene with cells that are a little off, each by a seed of its own."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from random import Random
from typing import Any

from pydantic import ValidationError

from ngcell.errors import CaseError
from ngcell.scene.bodies import BodyScene
from ngcell.scene.case import Case
from ngcell.scene.kinds import AnyCase

#: Share of the geometry by which members differ: small enough that what follows the geometry smoothly moves by less
#: than the default accuracy.
DEFAULT_SPREAD = 1e-3
#: More is another scene.
_LARGEST_SPREAD = 0.1


@dataclass(frozen=True)
class MemberChoice:
    """Which members of a case are run.

    Attributes
    ----------
    count : int
        Number of members, >= 2.
    seed : int
        Seed of the first, >= 0; the others follow one by one, so that more members contain fewer.
    spread : float
        Share of the geometry by which they differ, in (0, 0.1].

    Raises
    ------
    CaseError
        One of them is out of range.
    """

    count: int = 8
    seed: int = 0
    spread: float = DEFAULT_SPREAD

    def __post_init__(self) -> None:
        for name, low, high in (("count", 2, inf), ("seed", 0, inf)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
                raise CaseError(f"members: {name} = {value!r}; allowed: a whole number >= {low}")
        if not 0 < self.spread <= _LARGEST_SPREAD:
            raise CaseError(f"members: spread = {self.spread!r}; allowed: 0 < spread <= {_LARGEST_SPREAD:g}")

    @property
    def seeds(self) -> range:
        """Seed of each member."""
        return range(self.seed, self.seed + self.count)


def member_of(case: AnyCase | BodyScene, seed: int, spread: float) -> Case:
    """Return one member of a case: its wall is thicker or thinner by a share that is drawn with this seed.

    The share has a normal distribution of mean 0 and standard deviation `spread`. Expected numbers are those of the
    case itself, and left out.

    Raises
    ------
    CaseError
        If the scene has no cells that can be varied, or those of this seed are no tissue.
    """
    case = check_has_members(case)
    wall = case.tissue.wall * (1 + spread * Random(seed).gauss(0, 1))
    return case.model_copy(update={"tissue": _changed(case.tissue, seed, {"wall": wall}), "expected": ()})


def check_has_members(case: AnyCase | BodyScene) -> Case:
    """Return a case whose geometry can be varied.

    Raises
    ------
    CaseError
        If not.
    """
    if not isinstance(case, Case):
        raise CaseError("members differ in the cells of a tissue; this scene is of user-defined bodies and has none")
    if not hasattr(case.tissue, "wall") or not hasattr(case.tissue, "model_copy"):
        kind = getattr(case.tissue, "kind", type(case.tissue).__qualname__)
        raise CaseError(f"members differ in the cells of a tissue; those of tissue.kind = {kind!r} cannot be varied")
    return case


def _changed(tissue: Any, seed: int, values: dict[str, Any]) -> Any:
    """Return a tissue with other values, checked."""
    try:
        return type(tissue)(**{**dict(tissue), **values})
    except ValidationError as error:
        wrong = "; ".join(f"tissue.{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        raise CaseError(f"member of seed {seed}: {wrong}") from None
