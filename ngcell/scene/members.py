"""Members of a case: the same scene with cells that are a little off, each by a seed of its own."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

from pydantic import BaseModel

from ngcell.errors import CaseError
from ngcell.scene.bodies import BodyScene
from ngcell.scene.case import Case
from ngcell.scene.kinds import AnyCase
from ngcell.scene.registry import group

#: Share of the geometry by which members differ at most: small enough that what follows the geometry smoothly moves
#: by less than the default accuracy.
DEFAULT_SPREAD = 1e-3
#: More is another scene.
_LARGEST_SPREAD = 0.1
#: Kinds of tissues: the one that has no seed and can be varied, and what it is then.
_REGULAR, _PERTURBED = "honeycomb", "perturbed"


@dataclass(frozen=True)
class MemberChoice:
    """Which members of a case are run.

    Attributes
    ----------
    count : int
        Number of members, >= 2.
    seed : int
        Seed of the first, >= 0; the others follow one by one, so that more members contain fewer.
    spread : float, optional
        Share of the geometry by which they differ, in (0, 0.1]; by default `DEFAULT_SPREAD`, and what the tissue says
        where its cells are drawn from a seed.

    Raises
    ------
    CaseError
        One of them is out of range.
    """

    count: int = 8
    seed: int = 0
    spread: float | None = None

    def __post_init__(self) -> None:
        for name, low, high in (("count", 2, inf), ("seed", 0, inf)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
                raise CaseError(f"members: {name} = {value!r}; allowed: a whole number >= {low}")
        if self.spread is not None and not 0 < self.spread <= _LARGEST_SPREAD:
            raise CaseError(f"members: spread = {self.spread!r}; allowed: 0 < spread <= {_LARGEST_SPREAD:g}")

    @property
    def seeds(self) -> range:
        """Seed of each member."""
        return range(self.seed, self.seed + self.count)


def member_of(case: AnyCase | BodyScene, seed: int, spread: float | None = None) -> Case:
    """Return one member of a case, with the cells of this seed.

    A honeycomb becomes a perturbed one, whose corners are displaced by at most `spread` of the side, and whose walls
    are thicker or thinner by at most `spread` of their thickness. Cells that are drawn from a seed already are drawn
    from this one. Expected numbers are those of the case itself, and left out.

    Raises
    ------
    CaseError
        If the scene has no cells that can be varied, or those of this seed are no tissue.
    """
    case = check_has_members(case, spread)
    kind = type(case.tissue)
    values = {name: getattr(case.tissue, name) for name in kind.model_fields if name != "kind"}
    if not hasattr(case.tissue, "seed"):
        share = DEFAULT_SPREAD if spread is None else spread
        values |= {"spread": share, "wall_spread": share}
        kind = group("tissue").section(_PERTURBED)
    return case.model_copy(update={"tissue": _checked(kind, {**values, "seed": seed}), "expected": ()})


def check_has_members(case: AnyCase | BodyScene, spread: float | None = None) -> Case:
    """Return a case whose geometry can be varied.

    Raises
    ------
    CaseError
        If it cannot, or not by this spread.
    """
    if not isinstance(case, Case):
        raise CaseError("members differ in the cells of a tissue; this scene is of user-defined bodies and has none")
    kind = getattr(case.tissue, "kind", type(case.tissue).__qualname__)
    has_seed = hasattr(case.tissue, "seed")
    if not (isinstance(case.tissue, BaseModel) and (has_seed or kind == _REGULAR)):
        raise CaseError(f"members differ in the cells of a tissue; those of tissue.kind = {kind!r} cannot be varied")
    if has_seed and spread is not None:
        raise CaseError(
            f"members of tissue.kind = {kind!r} differ by its own keys and in their seed; "
            "allowed: no spread for members, but one of the tissue"
        )
    return case


def geometry_share(case: Case, spread: float | None) -> tuple[float, float]:
    """Return the share of a side, or of the thickness, by which members differ at most, and the side [length].

    The share is infinite where nobody knows.
    """
    tissue = case.tissue
    if not hasattr(tissue, "seed"):
        return DEFAULT_SPREAD if spread is None else spread, tissue.side
    if tissue.kind == _PERTURBED:
        return float(max(tissue.spread, tissue.wall_spread)), tissue.side
    return inf, 1.0


def _checked(kind: Any, values: dict[str, Any]) -> Any:
    """Return a tissue with these values."""
    try:
        return kind(**values)
    except CaseError as error:
        wrong = "; ".join(line.partition(": ")[2] for line in str(error).splitlines())
        raise CaseError(f"member of seed {values['seed']}: tissue: {wrong}") from None
