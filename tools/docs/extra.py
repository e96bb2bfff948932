"""What these tools take beside the package, told in a line before anything is done."""

from __future__ import annotations

from importlib.util import find_spec

from ngcell.errors import DependencyError


def check_extra(extra: str, *modules: str) -> None:
    """Check that the modules of an extra of the package are installed.

    Raises
    ------
    DependencyError
        If one is missing.
    """
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise DependencyError(f'{", ".join(missing)} missing: pip install ".[{extra}]"')
