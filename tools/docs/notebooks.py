"""Run all notebooks and keep their results: python -m tools.docs notebooks

Each runs in an empty folder, and is kept without what tells of the machine. The site shows them with these results.
"""

from __future__ import annotations

import os
import re
from base64 import b64decode
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from tools.commands import described
from tools.docs.extra import check_extra
from tools.places import DOCS, ROOT

NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
#: Seconds that a cell may take.
_LONGEST = 600


def write_pages(folder: Path) -> None:
    """Write a page, and the pictures in it, for each notebook."""
    folder.mkdir(exist_ok=True)
    for file in NOTEBOOKS:
        texts = [_cell(cell, folder, f"{file.stem}-{number}") for number, cell in enumerate(read(file).cells)]
        (folder / f"{file.stem}.md").write_text("\n\n".join(texts) + "\n")


def read(file: Path) -> Any:
    """Return a notebook."""
    import nbformat

    return nbformat.read(file, as_version=4)  # type: ignore[no-untyped-call]


def executed(notebook: Any, setting: str | None = None) -> Any:
    """Return a notebook after all of its cells have run in an empty folder.

    Parameters
    ----------
    notebook : notebook
        The notebook, which is changed.
    setting : str, optional
        Code that takes the place of the cell tagged `settings`.
    """
    from nbclient import NotebookClient

    for cell in notebook.cells:
        if setting is not None and "settings" in cell.metadata.get("tags", []):
            cell.source = setting
    with TemporaryDirectory() as folder:
        metadata = {"path": folder}
        client = NotebookClient(notebook, timeout=_LONGEST, kernel_name="python3", resources={"metadata": metadata})
        return client.execute(env={**os.environ, "PYTHONPATH": str(ROOT)})


@described(__doc__)
def command() -> None:
    check_extra("docs", "nbformat", "nbclient", "ipykernel")
    import nbformat

    for file in NOTEBOOKS:
        notebook = executed(read(file))
        for cell in notebook.cells:
            cell.metadata.pop("execution", None)
        notebook.metadata.pop("language_info", None)
        nbformat.write(notebook, file)  # type: ignore[no-untyped-call]
        click.echo(file)


def foreign(notebook: Any) -> list[str]:
    """Return the paths of a machine that a notebook holds."""
    usual = r"(?:/home/|/tmp/|/work/|/root/|/Users/|[A-Z]:\\+Users)[^\s\"']*"
    return re.findall(f"{usual}|{re.escape(str(ROOT))}", str(notebook))


def _cell(cell: Any, folder: Path, name: str) -> str:
    if cell.cell_type == "markdown":
        return str(cell.source)
    outputs = (_output(output, folder, f"{name}-{number}") for number, output in enumerate(cell.outputs))
    return "\n\n".join([f"```python\n{cell.source}\n```", *filter(None, outputs)])


def _output(output: Any, folder: Path, name: str) -> str:
    data = output.get("data", {})
    if "image/png" in data:
        (folder / f"{name}.png").write_bytes(b64decode(data["image/png"]))
        return f"![]({name}.png)"
    text = output.get("text") or data.get("text/plain", "")
    return f"```text\n{text.rstrip()}\n```" if text else ""
