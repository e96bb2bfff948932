"""Everything that ngcell raises on purpose.

::

    NgcellError                 an error that names the thing, the value, the limit and the remedy
    ├── CaseError               the case cannot be simulated as written                      exit 3
    │   ├── GeometryError       its shape cannot be built or meshed                          exit 3
    │   └── TooLarge            the memory of this machine is too small for it               exit 3
    ├── NotConverged            the load stepping ended before the last level            exit 4
    ├── OutputError             results cannot be written to, or read from, a folder         exit 4
    └── DependencyError         an installed library is missing or cannot do what is needed  exit 4

Usage errors of the command line (exit 2) belong to click. A run that converges but fails its certificate
raises nothing: it is a result, labelled as such, and only the command line turns it into exit 4.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar


class NgcellError(Exception):
    """Parent of every error that ngcell raises on purpose; the command line ends with its `exit_code`."""

    exit_code: ClassVar[int] = 4


class CaseError(NgcellError):
    """The case cannot be simulated as written; the message holds one line for each problem."""

    exit_code: ClassVar[int] = 3


class GeometryError(CaseError):
    """The shape that a case describes cannot be built or meshed."""


class TooLarge(CaseError):  # noqa: N818 - named as what is reported, not as a mistake
    """The memory of this machine is too small for the case."""


class NotConverged(NgcellError):  # noqa: N818 - named as what is reported, not as a mistake
    """The load path was not followed to its last level.

    Parameters
    ----------
    message : str
        What happened and what to try.
    outcome : str
        Name of the outcome, one of the closed list of the solver.
    steps : iterable, optional
        The accepted steps.

    Attributes
    ----------
    outcome : str
        As the parameter.
    steps : tuple
        Accepted steps, results that are kept: up to the last of them the load path is solved and judged. Empty if
        none was accepted.

    Examples
    --------
    >>> try:  # doctest: +SKIP
    ...     steps = ngcell.simulate(scene)
    ... except ngcell.NotConverged as stopped:
    ...     steps = stopped.steps
    """

    def __init__(self, message: str, *, outcome: str, steps: Iterable[Any] = ()) -> None:
        super().__init__(message)
        self.outcome = outcome
        self.steps: tuple[Any, ...] = tuple(steps)


class OutputError(NgcellError):
    """Results cannot be written to, or read from, a folder."""


class DependencyError(NgcellError):
    """An installed library is missing or cannot do what is needed."""
