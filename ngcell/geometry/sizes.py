"""How large elements are where nobody says: it follows from each body's own thickness, whatever its neighbours are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from netgen import occ

#: Default size of elements as a share of the body's thickness.
_SHARE = 0.5


@contextmanager
def sizes(parts: Sequence[occ.TopoDS_Shape], thicknesses: Sequence[float], size: float | None) -> Iterator[float]:
    """Yield the largest length of an element's edge [length]; by default each part has its own meanwhile.

    Parameters
    ----------
    parts : sequence of netgen.occ shapes
        One face or solid each; a smaller ``maxh`` of theirs counts.
    thicknesses : sequence of float
        Thickness of each [length].
    size : float or None
        What is asked for [length].
    """
    if size is not None:
        yield size
        return
    before = [part.maxh for part in parts]
    try:
        for part, thickness in zip(parts, thicknesses, strict=True):
            part.maxh = min(part.maxh, _SHARE * thickness)
        yield _SHARE * max(thicknesses)
    finally:
        for part, maxh in zip(parts, before, strict=True):
            part.maxh = maxh
