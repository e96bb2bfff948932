"""What a worker is handed for one case, and what it hands back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

#: What a run has left: outcome, provenance and accepted levels; see `ngcell.sweeps.case_run`.
Result = dict[str, Any]
#: Name of the file that a run leaves its result in.
RESULT = "result.json"
#: What a run says whose worker would compute something else.
OTHER_CODE = (
    "the worker has another ngcell, NGSolve or tissue file than the sweep; give all workers the same environment, and "
    "leave it as it is while a sweep runs"
)


@dataclass(frozen=True)
class Task:
    """One case to be run.

    Attributes
    ----------
    key : str
        By which its result is known.
    text : str
        The resolved case.
    minutes : float, optional
        Time on the clock after which the run ends.
    memory : float, optional
        Memory that its process may take besides its libraries [GiB].
    attempt : int
        How often it has been tried, this time included.
    picture : bool
        Whether a small picture of its tissue is drawn.
    """

    key: str
    text: str
    minutes: float | None = None
    memory: float | None = None
    attempt: int = 1
    picture: bool = False
