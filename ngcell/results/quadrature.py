"""How far the reported stored energy is from that of the same displacement, integrated by a much finer rule."""

from __future__ import annotations

from collections.abc import Sequence

from ngcell.mechanics.symbolic import SymbolicTerm
from ngcell.mechanics.term import Configuration, Role, Term


def quadrature_error(terms: Sequence[Term], at: Configuration) -> float:
    """Return the sum over all terms of what a rule of higher order adds to their stored energy [stress * length**2].

    It is NaN where the finer rule finds an inverted element. Terms that offer no finer rule are left out; see
    `ngcell.mechanics.symbolic.SymbolicTerm.finer`.

    Notes
    -----
    Stored energies are no polynomials: logarithms and powers of J converge with the order as fast as J varies little.
    Where walls are so distorted, or so nearly incompressible, that the rule misses energy between its points, the
    minimum is that of another energy than the one that is meant.
    """
    total = 0.0
    for term in terms:
        if isinstance(term, SymbolicTerm) and term.role is Role.INTERNAL and term.finer_form is not None:
            total += abs(term.finer_form.energy(at.displacement) - term.value(at))
    return total
