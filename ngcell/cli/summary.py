"""A run in a few lines of text: the outcome, the certificate, where the files are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ngcell.run import Recording


def summary_lines(recording: Recording, folder: Path) -> Iterator[str]:
    """Yield what the terminal shows of a finished run: of its summary, the table `certificate`."""
    yield f"outcome      {recording.outcome}"
    yield f"certificate  {'passed' if recording.certified else 'NOT PASSED'}"
    yield from table_lines(recording.summary.get("certificate", {}), indent=2)
    yield f"results      {folder}"


def table_lines(table: Mapping[str, Any], indent: int = 0) -> Iterator[str]:
    """Yield a line for each entry of a table, its inner tables indented below their name."""
    width = max((len(name) for name, value in table.items() if not isinstance(value, Mapping)), default=0)
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield f"{' ' * indent}{_words(name)}"
            yield from table_lines(value, indent + 2)
        else:
            yield f"{' ' * indent}{_words(name):{width}}  {_shown(value)}"


def _words(name: object) -> str:
    return str(name).replace("_", " ")


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if value is None:
        return "none"
    return ", ".join(map(_shown, value)) if isinstance(value, (list, tuple)) else str(value)
