"""How a run can end: a closed list, each with what happened and what to try."""

from __future__ import annotations

from enum import Enum


class Outcome(Enum):
    """The outcomes of a run; the value is what the user reads."""

    CERTIFIED = "converged and certified"
    NOT_CERTIFIED = "converged, but a check of the certificate failed; see the certificate for which one"
    TIED_FAILED = (
        "the tied solid found no equilibrium, even in the smallest load step; "
        "the load may be past the point where the walls buckle or elements invert: lower it, or refine the mesh"
    )
    RELEASE_FAILED = (
        "the released walls found no equilibrium, even in the smallest load step; "
        "refine the mesh (mesh.size), round the corners (tissue.corner_radius) or ask for smaller load steps"
    )
    OUT_OF_TIME = (
        "the run has taken the time that it was given (--max-minutes); resume it with more, or without a limit"
    )
    OUT_OF_ITERATIONS = (
        "the step that follows has taken all the factorisations and trial steps that it is given; "
        "ask for smaller load steps, hold bodies that a load drives and nothing holds, or refine the mesh"
    )
    STOPPED = "stopped from outside"
