"""What holds for all tests."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> None:
    """Small problems on one thread: waiting threads would take ten times the processor time."""
    import ngsolve

    ngsolve.SetNumThreads(1)
