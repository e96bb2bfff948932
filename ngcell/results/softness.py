"""What a finite penalty takes of the energy where loads act.

With prescribed displacements alone the energy rises to that of rigid contact by what penalty terms store, and by more
where they are softer than bodies: by no more than forces times overlaps, twice as much. Loads do work as overlaps go,
which that says nothing of: to first order, what is stored changes by that work, and by what penalty terms give back.
"""

from __future__ import annotations

from dataclasses import replace
from math import isfinite

from ngcell.mechanics.term import Role
from ngcell.problem.problem import Problem
from ngcell.problem.state import State
from ngcell.results.error import Numbers


def loads_move_overlaps(problem: Problem, state: State) -> bool:
    """Return whether loads act on bodies that overlap by a finite penalty."""
    has_overlaps = not problem.has_multipliers and problem.overlap_work(state.at) > 0
    return has_overlaps and bool(problem.force(state.at, Role.LOAD).any())


def beside_rigid_contact(numbers: Numbers, problem: Problem, state: State, rigid: State) -> Numbers:
    """Return numbers of a state whose energy and forces err by no less than they change to a state of rigid contact.

    By balance what is stored changes by the work of loads on the way there, to first order, and by half of the contact
    energy more. The energy of the state there would not do: a straight way may lead through other walls.
    """
    way, overlaps = rigid.displacement - state.displacement, problem.overlap_work(state.at)
    changed = abs(overlaps / 2 - float(problem.force(state.at, Role.LOAD) @ way))
    if not isfinite(changed):
        return numbers
    numbers = replace(numbers, besides=numbers.besides + max(changed - overlaps, 0.0))
    if not isfinite(rigid.energy):  # too far for forces
        return numbers
    contact = problem.gradient_of_constraints(state) * problem.free
    others = (problem.gradient(rigid) - problem.gradient_of_constraints(rigid)) * problem.free
    squared, left = float(contact @ contact), float((contact + others) @ contact)  # rigid contact balances the others
    return replace(numbers, stiffer=abs(left) / squared if squared else 0.0)  # 0: all on supports
