"""A Ctrl-C that a destructor swallows still ends what is running."""

from __future__ import annotations

import signal
import warnings

import pytest

from ngcell.cli.interrupts import remembered_interrupts


class Interrupted:
    """Is interrupted as it goes."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_that_is_dropped_is_told_at_the_next_check():
    before = signal.getsignal(signal.SIGINT)
    with warnings.catch_warnings(), remembered_interrupts() as check:
        check()
        gone = Interrupted()
        del gone  # Python drops what is raised here
        with pytest.raises(KeyboardInterrupt):
            check()
    assert signal.getsignal(signal.SIGINT) is before
