"""Progress of a sweep on stderr: a live line on a terminal, elsewhere a line every ten seconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from ngcell.cli.pace import duration
from ngcell.cli.progress import live_console
from ngcell.cli.streams import note

if TYPE_CHECKING:
    from ngcell.sweeps.sweep import Ended

ShowEnded = Callable[["Ended"], None]
#: Time between two lines where there is no terminal [s].
_BETWEEN = 10.0


@contextmanager
def silent() -> Iterator[ShowEnded]:
    """Show nothing."""
    yield lambda ended: None


@contextmanager
def sweep_progress() -> Iterator[ShowEnded]:
    """Show how far a sweep is, and each run that is not certified."""
    console, failed = live_console(), _not_certified
    if console is None:
        last = [monotonic()]

        def tell(ended: Ended) -> None:
            if failed(ended):
                note(failed(ended))
            if monotonic() - last[0] > _BETWEEN or ended.done == ended.total:
                last[0] = monotonic()
                note(line(ended))

        yield tell
        return
    with console.status("starting the workers") as status:

        def show(ended: Ended) -> None:
            if failed(ended):
                console.print(failed(ended), markup=False, soft_wrap=True)
            status.update(f"{line(ended)} (Ctrl-C stops and keeps what has ended)")

        yield show


def line(ended: Ended) -> str:
    """Return how far a sweep is, in one line."""
    if ended.done == ended.total:
        return f"{ended.done} of {ended.total} cases"
    if ended.left is None:
        return f"{ended.done} of {ended.total} cases, time left not known yet"
    spread = round(100 * ended.left.share)
    return f"{ended.done} of {ended.total} cases, about {duration(ended.left.seconds)} left (± {spread} %)"


def _not_certified(ended: Ended) -> str:
    result = ended.result
    return "" if result["outcome"] == "certified" else f"case {ended.number}: {result['outcome']}: {result['detail']}"
