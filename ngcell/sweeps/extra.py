"""Libraries that only sweeps need, imported when they are needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ngcell.errors import DependencyError


def needed(module: str) -> Any:
    """Return a module of the extra `sweep`.

    Raises
    ------
    DependencyError
        It is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        library = module.partition(".")[0]
        raise DependencyError(f'sweeps need {library}; install it by: pip install "ngcell[sweep]"') from error
