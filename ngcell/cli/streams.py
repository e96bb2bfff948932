"""The standard streams, which whoever starts the command may have closed, or led to a disk that is full."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

import click


def open_standard_streams() -> None:
    """Let streams that are closed lead nowhere.

    Else the next file that is opened would take the number of a closed one, and get what libraries print.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the smallest free number, which is this one
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - as long as the process


def give_up_stream(number: int) -> None:
    """Lead a stream that cannot be written nowhere, with what it still holds."""
    with suppress(OSError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, number)
        os.close(nowhere)


def note(line: str) -> None:
    """Write a line to stderr; a run goes on where it cannot be written."""
    try:
        click.echo(line, err=True)
    except OSError:
        give_up_stream(2)
