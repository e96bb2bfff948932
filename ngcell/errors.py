"""Everything that ngcell raises on purpose.

::

    NgcellError                 an error that names the thing, the value, the limit and the remedy
    ├── CaseError               the case cannot be simulated as written                      exit 3
    │   └── GeometryError       its shape cannot be built or meshed                          exit 3
    ├── NotConverged            the load path was not followed to its last level            exit 4
    ├── OutputError             results cannot be written to, or read from, a folder         exit 4
    └── DependencyError         an installed library is missing or cannot do what is needed  exit 4

Usage errors of the command line (exit 2) belong to click. A run that converges but fails its certificate
raises nothing: it is a result, labelled as such, and the command line alone turns it into exit 4.
"""

from __future__ import annotations

from typing import Any, ClassVar


class NgcellError(Exception):
    """Parent of every error that ngcell raises on purpose; `exit_code` is what the command line answers."""

    exit_code: ClassVar[int] = 4


class CaseError(NgcellError):
    """The case cannot be simulated as written; the message holds one line for each problem."""

    exit_code: ClassVar[int] = 3


class GeometryError(CaseError):
    """The shape that a case describes cannot be built or meshed."""


class NotConverged(NgcellError):  # noqa: N818 - named as what is reported, not as a mistake
    """The load path was not followed to its last level.

    Parameters
    ----------
    message : str
        What happened and what to try.
    outcome : str
        Name of the outcome, one of the closed list of the solver.
    steps : tuple
        The steps that were accepted before: those of a simulation, or reports of a recording, whose folder keeps them.
    """

    def __init__(self, message: str, *, outcome: str, steps: tuple[Any, ...] = ()) -> None:
        super().__init__(message)
        self.outcome = outcome
        self.steps = steps

    @property
    def record_count(self) -> int:
        """Number of steps that were accepted before."""
        return len(self.steps)


class OutputError(NgcellError):
    """Results cannot be written to, or read from, a folder."""


class DependencyError(NgcellError):
    """An installed library is missing or cannot do what is needed."""
