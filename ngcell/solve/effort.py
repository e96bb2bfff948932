"""What a minimisation costs."""

from __future__ import annotations

from dataclasses import dataclass, field

#: Ratio of bulk to shear modulus up to which a step is given the usual work: that of the walls of the shipped cases.
USUAL_BULK = 50.0


@dataclass
class Effort:
    """What was spent."""

    iterations: int = 0
    factorisations: int = 0
    evaluations: int = 0
    refusals: int = 0
    cutbacks: int = 0

    def __sub__(self, other: Effort) -> Effort:
        return Effort(**{name: getattr(self, name) - getattr(other, name) for name in vars(self)})

    def __add__(self, other: Effort) -> Effort:
        return Effort(**{name: getattr(self, name) + getattr(other, name) for name in vars(self)})

    @property
    def work(self) -> int:
        """What takes the time, whatever the number of iterations: factorisations and refused trial steps."""
        return self.factorisations + self.refusals

    def copy(self) -> Effort:
        """Return a copy that no longer changes."""
        return Effort(**vars(self))


class OutOfIterations(Exception):  # noqa: N818 - named as what is reported, not as a mistake
    """A step has taken all the work that it was given."""


def share_of_work(bulk: float) -> float:
    """Return how many times the usual work a step takes at a ratio of bulk to shear modulus, >= 1.

    Newton's method crawls along curved valleys of constant volume. A step s leaves the floor of one of the radius R by
    ``s**2 / 2 R``: what it gains is proportional to ``mu s``, what it costs to ``kappa s**4``, and so the longest that
    lowers the energy to ``(mu / kappa)**(1/3)``.
    """
    return float(max(bulk / USUAL_BULK, 1.0) ** (1 / 3))


@dataclass
class Budget:
    """The work of a step, all minimisers together, and all attempts: factorisations and refused trial steps."""

    most: float = float("inf")
    _efforts: list[Effort] = field(default_factory=list)
    _before: int = 0
    _times: float = 1.0

    def renew(self, times: float = 1.0) -> None:
        """Begin with the next step, which may take so many times the usual work."""
        self._before, self._times = self._work, times

    def charge(self, effort: Effort) -> None:
        """Count what a minimiser spends from now on; raise `OutOfIterations` if all of them have spent too much."""
        if not any(known is effort for known in self._efforts):
            self._efforts.append(effort)
        if self._work - self._before >= self._times * self.most:
            raise OutOfIterations

    @property
    def used(self) -> float:
        """The share of the work of this step that is spent."""
        return (self._work - self._before) / (self._times * self.most)

    @property
    def _work(self) -> int:
        return sum(effort.work for effort in self._efforts)
