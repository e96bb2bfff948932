"""What holds for all tests."""

from __future__ import annotations

import os

import pytest

# Small problems on one thread: waiting threads would take ten times the processor time, and workers share the cores.
# Set before any library reads it; processes that tests start inherit it.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> None:
    import ngsolve

    ngsolve.SetNumThreads(1)
