"""What an observable offers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.results.quantities import View

Array = NDArray[np.float64]


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
    seen = set(taken)
    for observable in observables:
        if observable.name in seen:
            what = "a column" if observable.name in taken else "another observable"
            raise CaseError(f"observable {observable.name!r}: {what} has this name; allowed: a name of its own")
        seen.add(observable.name)


def observed(observables: Sequence[Observable], view: View) -> tuple[dict[str, float], Mapping[str, Array]]:
    """Return the columns and the fields of all observables."""
    values = {observable.name: np.asarray(observable.values(view), dtype=float) for observable in observables}
    columns = {name: float(value.mean()) for name, value in values.items()}
    return columns, {name: value for name, value in values.items() if value.ndim}
