"""What VTK would tell of damaged files is told in one line."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def silent_vtk() -> Iterator[None]:
    """Let VTK, and what hears it, tell nothing."""
    from vtkmodules.vtkCommonCore import vtkLogger, vtkObject

    verbosity, disabled = vtkLogger.GetCurrentVerbosityCutoff(), logging.root.manager.disable
    vtkObject.GlobalWarningDisplayOff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    logging.disable(logging.ERROR)
    try:
        yield
    finally:
        logging.disable(disabled)
        vtkLogger.SetStderrVerbosity(verbosity)
        vtkObject.GlobalWarningDisplayOn()
