"""Pages on the commands, which sphinx-click makes, and on the public names, which autodoc makes."""

from __future__ import annotations

from itertools import groupby

import ngcell

#: Title of each part of the package that has public names, in the order of the page.
TITLES = {
    "run": "Run a scene",
    "ensemble": "Run members of a scene",
    "recording": "A run that is being recorded",
    "scene": "Cases and scenes",
    "geometry": "Tissues and bodies",
    "mechanics": "Laws, contents of cells, loads and supports",
    "contact": "Contact and cohesion",
    "solve": "Strategies and numbers of the solver",
    "build": "Steps and options",
    "results": "Observables",
    "errors": "Errors",
}


def commands() -> str:
    """Return the page of the commands."""
    text = "What follows is what ``--help`` tells. What it means: :doc:`../command-line`."
    listed = ".. click:: ngcell.cli:ngcell\n   :prog: ngcell\n   :nested: full\n"
    return f"{_titled('All commands', '=')}\n{text}\n\n{listed}"


def names() -> str:
    """Return the page of the public names, one section for each part of the package."""
    text = "The names of ``ngcell``. How scripts use them: :doc:`../python` and the how-to pages."
    titled = {part: _titled(TITLES.get(part, part.capitalize()), "-") for part, _ in sections()}
    listed = (f"{titled[part]}\n{''.join(map(_entry, found))}" for part, found in sections())
    return f"{_titled('Python reference', '=')}\n{text}\n\n.. module:: ngcell\n\n" + "\n".join(listed)


def sections() -> list[tuple[str, list[str]]]:
    """Return the public names of each part of the package."""
    parts = {name: getattr(ngcell, name).__module__.split(".")[1] for name in ngcell.__all__}
    order = [*TITLES, *sorted(set(parts.values()) - TITLES.keys())]
    listed = sorted(ngcell.__all__, key=lambda name: (order.index(parts[name]), name.lower()))
    return [(part, list(found)) for part, found in groupby(listed, parts.__getitem__)]


def _entry(name: str) -> str:
    if not isinstance(getattr(ngcell, name), type):
        return f".. autofunction:: ngcell.{name}\n\n"
    return f".. autoclass:: ngcell.{name}\n   :members:\n   :exclude-members: model_config, model_post_init\n\n"


def _titled(text: str, line: str) -> str:
    return f"{text}\n{line * len(text)}\n"
