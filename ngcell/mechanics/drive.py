"""How a term that is driven by the load factor takes in work."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Drive:
    """How a term that is driven by the load factor takes in work.

    Attributes
    ----------
    share : float
        Share of the full load that acts.
    potential : float
        Potential at the full load [energy]; it falls as the load does work.
    rate : float
        Work for each unit of the share that is taken in besides [energy].
    """

    share: float
    potential: float
    rate: float
