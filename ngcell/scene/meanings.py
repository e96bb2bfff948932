"""What docstrings say of tables of a case and of their entries."""

from __future__ import annotations

import re
from inspect import cleandoc

_SHARED = re.compile(r"those of `ngcell\.[\w.]+`")
_ENTRY = re.compile(r"^(\w+(?:, \w+)*) : [^\n]*\n((?:(?: +[^\n]*)?\n?)*)", re.MULTILINE)


def described(text: str) -> tuple[str, dict[str, str]]:
    """Return what a docstring says of a table, and what of each of its entries."""
    about, _, rest = text.partition("\nParameters\n----------\n")
    found = _ENTRY.findall(re.split(r"\n\n\w+\n-+\n", rest)[0])
    told = {entry: " ".join(meaning.split()) for entries, meaning in found for entry in entries.split(", ")}
    return _SHARED.sub("those below", about.strip()), told


def meanings(table: type) -> dict[str, str]:
    """Return what is said of each entry of a table: by itself, or by a class that it shares entries with."""
    parents = [parent for parent in table.__mro__[::-1] if parent.__module__.partition(".")[0] != "pydantic"]
    told = (described(cleandoc(parent.__doc__ or ""))[1] for parent in parents)
    return {entry: meaning for each in told for entry, meaning in each.items()}
