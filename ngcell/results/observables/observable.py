"""What an observable offers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.results.quantities import View

Array = NDArray[np.float64]

#: Columns of tables that rows of steps become parts of.
_ELSEWHERE = (
    "accuracy", "attempts", "case", "detail", "failed_checks", "host", "key", "level", "member", "memory_gib",
    "ngcell", "ngsolve", "outcome", "processor_seconds", "seed", "unknowns",
)  # fmt: skip
#: How names begin that files of results have for what they tell of themselves.
_OWN = "ngcell_"


@runtime_checkable
class Observable(Protocol):
    """Something that is measured on every accepted step."""

    @property
    def name(self) -> str:
        """Name of the column of `history.csv`, and of the field."""

    def values(self, view: View) -> float | Array:
        """Return a number, or one value a body, shape (bodies,), which becomes a field; the column is then their mean.
        """


def check_names(observables: Sequence[Observable], taken: Collection[str]) -> None:
    """Check that each observable has a name of its own, which no other column has.

    Raises
    ------
    CaseError
        If one has not.
    """
    taken = {*taken, *_ELSEWHERE}
    seen = set(taken)
    for observable in observables:
        name = getattr(observable, "name", None)
        if not isinstance(name, str) or not name or name.startswith(_OWN):
            allowed = f"a text that does not begin with {_OWN}"
            raise CaseError(f"observable {observable!r} has the name {name!r}; allowed: {allowed}")
        if name in seen:
            what = "a column or a field" if name in taken else "another observable"
            raise CaseError(f"observable {name!r}: {what} has this name; allowed: a name of its own")
        seen.add(name)


def observed(observables: Sequence[Observable], view: View) -> tuple[dict[str, float], Mapping[str, Array]]:
    """Return the columns and the fields of all observables.

    Raises
    ------
    CaseError
        If an observable returns something else than a number, or one value a body.
    """
    bodies = view.problem.space.body_count
    values = {observable.name: _checked(observable.name, observable.values(view), bodies) for observable in observables}
    columns = {name: float(value.mean()) for name, value in values.items()}
    return columns, {name: value for name, value in values.items() if value.ndim}


def _checked(name: str, values: object, bodies: int) -> Array:
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if values is None or found.shape not in ((), (bodies,)):
        told = f"shape {np.shape(values)}" if isinstance(values, np.ndarray) else f"{values!r:.60}"
        raise CaseError(f"observable {name!r} returned {told}; allowed: a number, or one a body, shape ({bodies},)")
    return found
