"""Which columns the table of a study has, known before anything runs."""

from __future__ import annotations

from collections.abc import Container
from difflib import get_close_matches

from ngcell.errors import CaseError
from ngcell.results.rupture.strength import COLUMNS
from ngcell.scene import AnyCase
from ngcell.scene.study_reader import WrittenStudy
from ngcell.sweeps.cases import Cases
from ngcell.sweeps.table import known_outputs


def outputs_of(written: WrittenStudy, cases: Cases, refused: Container[int]) -> tuple[str, ...]:
    """Return the outputs that a study asks for; by default all that its first and its last case have.

    Raises
    ------
    CaseError
        No run has such a column.
    """
    asked, known = written.study.outputs, list(known_outputs())
    if asked and set(asked) <= set(known):
        return tuple(dict.fromkeys(asked))
    numbers = [number for number in range(len(cases)) if number not in refused]
    for number in dict.fromkeys((numbers[0], numbers[-1])):
        known += [name for name in _observed(cases.case(number)) if name not in known]
    for name in asked:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise CaseError(
                f"{written.where('outputs')}: outputs: no run has the column {name!r}{hint}; "
                f"allowed: {', '.join(known)}"
            )
    return tuple(dict.fromkeys(asked)) or tuple(known)


def _observed(case: AnyCase) -> list[str]:
    """Return the columns that the observables of a case, and the strength of its walls, add."""
    laws = [getattr(case, "material", None), *(body.material for body in getattr(case, "bodies", ()))]
    limits = [getattr(law, name, None) for law in laws for name in ("strength", "stretch_limit")]
    utilisation = COLUMNS if any(limit is not None for limit in limits) else ()
    return [*(observable.name for observable in case.observables), *utilisation]
