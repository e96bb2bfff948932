"""How a run of a sweep can end: a closed list."""

from __future__ import annotations

from enum import Enum


class Ending(Enum):
    """The outcomes of a run in a sweep: the name is what the table has, the value what it means."""

    CERTIFIED = "converged and certified"
    NOT_CERTIFIED = "converged, but a check of the certificate failed"
    NOT_AS_EXPECTED = "converged, but a number is not as the case expects"
    TIED_FAILED = "the tied solid found no equilibrium"
    RELEASE_FAILED = "the released walls found no equilibrium"
    OUT_OF_ITERATIONS = "the step that follows took all the iterations that it is given"
    OUT_OF_TIME = "the run took the time that it was given"
    REFUSED = "the case cannot be simulated as written"
    BAD_GEOMETRY = "its shape cannot be built or meshed"
    OUT_OF_MEMORY = "the memory was too small"
    KILLED = "its process was killed"
    FAILED = "an error that is none of the others"

    @property
    def told(self) -> str:
        """Name in the table."""
        return self.name.lower().replace("_", "-")

    @property
    def is_final(self) -> bool:
        """Whether another try ends in the same way."""
        return self not in _PASSING


_PASSING = {Ending.OUT_OF_TIME, Ending.OUT_OF_MEMORY, Ending.KILLED, Ending.FAILED}
