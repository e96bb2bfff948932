"""The numbers of the solver and of contact that no case names, as one record that is handed down."""

from __future__ import annotations

from dataclasses import dataclass, field

from ngcell.contact.options import ContactOptions
from ngcell.solve.options import SolverOptions


@dataclass(frozen=True)
class Options:
    """Numbers that results do not depend on; the tables of `python -m tools.studies constants` show it.

    Attributes
    ----------
    solver : SolverOptions
        Those of minimisation, continuation and load stepping.
    contact : ContactOptions
        Those of contact.
    """

    solver: SolverOptions = field(default_factory=SolverOptions)
    contact: ContactOptions = field(default_factory=ContactOptions)
