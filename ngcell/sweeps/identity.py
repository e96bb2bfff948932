"""What a result depends on, as one name: the resolved case, the files that it names, and the code that runs it."""

from __future__ import annotations

from hashlib import sha256

from ngcell.recording import file_told
from ngcell.scene import AnyCase, resolved_toml
from ngcell.sweeps.code import code_told


def content_key(case: AnyCase) -> str:
    """Return the name by which the result of a case is known, whatever its title: SHA-256, 64 hexadecimal digits."""
    untitled = case.model_copy(update={"title": "", "source": ""})
    return sha256(f"{resolved_toml(untitled)}{file_told(case)}# {code_told()}\n".encode()).hexdigest()
