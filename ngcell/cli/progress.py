"""Progress of a run on stderr: a line for each accepted step and, on a terminal, a live line for the current one."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

from ngcell.cli.streams import note
from ngcell.cli.summary import with_error

if TYPE_CHECKING:
    from rich.console import Console

    from ngcell.results.record import StepRecord


class ShowStep(Protocol):
    """Shows an accepted step; `of` says whose, where there is more than one run."""

    def __call__(self, record: StepRecord, of: str = "") -> None: ...


@contextmanager
def silent_progress() -> Iterator[ShowStep]:
    """Show nothing."""
    yield lambda record, of="": None


@contextmanager
def step_progress() -> Iterator[ShowStep]:
    """Show each accepted step as a line and, on a terminal, a live line for the current step below them."""
    console = live_console()
    if console is None:
        yield lambda record, of="": note(of + step_line(record))
        return
    with console.status("building the scene") as status:

        def show(record: StepRecord, of: str = "") -> None:
            console.print(of + step_line(record), markup=False, soft_wrap=True)
            status.update(f"{of}solving beyond load {record.load_factor:.4f} (Ctrl-C stops and keeps the steps)")

        yield show


def live_console() -> Console | None:
    """Return the terminal that stderr is; None where it is none."""
    if not (sys.stderr.isatty() or os.environ.get("FORCE_COLOR") or os.environ.get("TTY_COMPATIBLE")):
        return None  # what rich would find out, without the time to import it
    from rich.console import Console

    console = Console(stderr=True, highlight=False)
    return console if console.is_terminal else None


def step_line(record: StepRecord) -> str:
    """Return an accepted step in one line."""
    return (
        f"step {record.step:3d}  {record.phase:8s}  load {record.load_factor:6.4f}  "
        f"energy {with_error(record.energy, record.energy_error):18s}  "
        f"largest gap {record.largest_gap:10.3e}  parted {record.parted_pairs:4d}  "
        f"iterations {record.iterations:3d}  {record.seconds:6.1f} s"
        f"{'' if record.certified else '  not certified'}"
    )
