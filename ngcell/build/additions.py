"""What a script adds to a scene, and no case file can say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ngcell.build.options import Options
from ngcell.build.problems import OwnTerm
from ngcell.build.simulation import Simulation
from ngcell.clock import Clock
from ngcell.results.observables.observable import Observable
from ngcell.scene import AnyCase, BodyScene
from ngcell.scene.kinds import check_is_scene
from ngcell.solve.strategies.strategy import Strategy

#: What lines of a recorded case begin with that tell of additions.
_MARK = "# From a script: "


@dataclass(frozen=True, eq=False)
class Additions:
    """What a script adds.

    Attributes
    ----------
    terms : sequence of callable
        Further terms of the energy, each made from the displacement space.
    observables : sequence of Observable
        What is measured besides what every run measures.
    strategy : Strategy, optional
        How the load path is followed, in place of what the scene says.
    options : Options, optional
        The numbers of the solver and of contact.
    """

    terms: Sequence[OwnTerm] = ()
    observables: Sequence[Observable] = ()
    strategy: Strategy | None = None
    options: Options | None = None

    def simulation(self, scene: AnyCase | BodyScene, clock: Clock | None = None) -> Simulation:
        """Return the scene with what was added, built."""
        check_is_scene(scene)
        return Simulation(
            scene,
            clock,
            terms=self.terms,
            observables=self.observables,
            strategy=self.strategy,
            options=self.options,
        )

    @property
    def told(self) -> str:
        """A line for each addition, as comments of a recorded case; empty where nothing was added."""
        return "".join(f"{_MARK}{name} = {_named(value)}\n" for name, value in self._given())

    def _given(self) -> Iterator[tuple[str, Any]]:
        yield from (("term", term) for term in self.terms)
        yield from (("observable", observable) for observable in self.observables)
        if self.strategy is not None:
            yield "strategy", self.strategy
        if self.options not in (None, Options()):
            yield "options", self.options


def told_additions(case_text: str) -> str:
    """Return what a recorded case tells of additions, as `Additions.told` does."""
    return "".join(line for line in case_text.splitlines(keepends=True) if line.startswith(_MARK))


def _named(value: Any) -> str:
    """Return what an object says of itself on one line; its name, or that of its class, where it says nothing."""
    told = " ".join(repr(value).split())
    has_no_words = hasattr(value, "__qualname__") or " object at 0x" in told
    return str(getattr(value, "__qualname__", type(value).__qualname__)) if has_no_words else told
