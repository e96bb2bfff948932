"""What the terms of a problem report, put together; no term is asked for by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.term import Configuration, Interaction, Term

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def interaction(terms: Sequence[Term], at: Configuration) -> Interaction:
    """Return the forces of all terms between bodies."""
    found = [one for term in terms if (one := term.interaction(at)) is not None]
    nobody, dimension = np.zeros((0, 2), dtype=np.int64), len(at.positions)
    return Interaction(
        np.concatenate([nobody, *(one.bodies for one in found)]),
        np.concatenate([nobody, *(one.facets for one in found)]),
        np.concatenate([np.zeros((0, dimension)), *(one.force for one in found)]),
        np.concatenate([np.zeros(0), *(one.normal for one in found)]),
    )


def contact_pressures(terms: Sequence[Term], at: Configuration, points: object) -> Array | None:
    """Return the nominal contact pressure at points of walls [stress]; None where nothing presses."""
    found = [pressure for term in terms if (pressure := term.contact_pressures(at, points)) is not None]
    return sum(found[1:], start=found[0]) if found else None


def deepest_overlap(terms: Sequence[Term], at: Configuration, thickness: Array) -> float | None:
    """Return the deepest overlap that terms see over the thickness of the thinner body; None where none keeps bodies
    apart. `thickness` has shape (bodies,) [length]."""
    found = [overlap for term in terms if (overlap := term.overlap_over(at, thickness)) is not None]
    return max(found) if found else None


def stress(terms: Sequence[Term], gradient: Array, element: Index) -> Array:
    """Return the Cauchy stress [stress], shape (n, 3, 3), of deformation gradients in elements; NaN where J <= 0."""
    total = np.zeros_like(gradient)
    with np.errstate(divide="ignore", invalid="ignore"):
        for term in terms:
            part = term.stress(gradient, element)
            total = total if part is None else total + part
    return total


def cell_fields(terms: Sequence[Term], at: Configuration, load_factor: float) -> dict[str, Array]:
    """Return fields with one value a body, by name; later terms replace those of earlier ones."""
    return {name: field for term in terms for name, field in term.cell_fields(at, load_factor).items()}


def columns(terms: Sequence[Term], at: Configuration) -> dict[str, float]:
    """Return the numbers that terms have for the table of steps."""
    return {name: number for term in terms for name, number in term.columns(at).items()}


def stored_in_bodies(terms: Sequence[Term], at: Configuration, bodies: int) -> Array:
    """Return what each of so many bodies stores [energy], shape (bodies,)."""
    total = np.zeros(bodies)
    for term in terms:
        part = term.stored_in_bodies(at)
        total = total if part is None else total + part
    return total


def broken_share(terms: Sequence[Term], at: Configuration, pairs: Index) -> Array:
    """Return the share of the bonds of each pair of bodies, shape (pairs, 2), that are broken; NaN without bonds."""
    numbers = {(int(one), int(two)): number for number, (one, two) in enumerate(pairs)}
    length, broken = np.zeros(len(pairs)), np.zeros(len(pairs))
    for bodies, weight, is_broken in filter(None, (term.bonds_at(at) for term in terms)):
        pair = np.array([numbers.get((int(one), int(two)), -1) for one, two in bodies], dtype=np.int64)
        known = pair >= 0
        length += np.bincount(pair[known], weight[known], len(pairs))
        broken += np.bincount(pair[known], (weight * is_broken)[known], len(pairs))
    return np.asarray(np.divide(broken, length, out=np.full(len(pairs), np.nan), where=length > 0))


def checks(terms: Sequence[Term], at: Configuration, scales: Scales) -> tuple[Check, ...]:
    """Return the checks of all terms."""
    return tuple(check for term in terms for check in term.checks(at, scales))
