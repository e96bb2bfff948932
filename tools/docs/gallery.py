"""The gallery: a page for each script of docs/gallery, with what it printed and drew, and the seconds that it took.

A script is run in an empty folder by an interpreter of its own; the last line that it prints names its picture. Results
are kept until the script or the package changes.
"""

from __future__ import annotations

import ast
import hashlib
import json
import resource
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tools.places import DOCS, ROOT

SCRIPTS = sorted((DOCS / "gallery").glob("*.py"))
#: How a script names its picture, last of all.
SHOWN = "picture: "


@dataclass(frozen=True)
class Shown:
    """What a script left.

    Attributes
    ----------
    printed : str
        What it printed, without the name of its picture.
    seconds : float
        Processor time, the imports of Python's packages included [s].
    """

    printed: str
    seconds: float


def write_pages(folder: Path, kept: Path | None) -> None:
    """Write a page for each script, and the page that lists them.

    Parameters
    ----------
    folder : Path
        Where pages go.
    kept : Path, optional
        Where results are kept between builds; without it no script is run.
    """
    folder.mkdir(exist_ok=True)
    entries = []
    for script in SCRIPTS:
        shown = None if kept is None else result(script, kept)
        if kept is not None:
            shutil.copyfile(kept / f"{script.stem}.png", folder / f"{script.stem}.png")
        (folder / f"{script.stem}.md").write_text(page(script, shown))
        entries.append(_entry(script, shown))
    (folder / "index.md").write_text(_list(entries))


def result(script: Path, kept: Path) -> Shown:
    """Return what a script left; it is run unless the same script has been, with the same package."""
    kept.mkdir(parents=True, exist_ok=True)
    record, picture, version = kept / f"{script.stem}.json", kept / f"{script.stem}.png", _version(script)
    told = json.loads(record.read_text()) if record.exists() else {}
    if told.pop("version", None) == version:
        return Shown(**told)
    shown = run(script, picture)
    record.write_text(json.dumps({"version": version, **asdict(shown)}))
    return shown


def run(script: Path, picture: Path) -> Shown:
    """Run a script, save its picture and return what it printed.

    Raises
    ------
    RuntimeError
        If the script fails, or names no picture.
    """
    with TemporaryDirectory() as folder:
        before = _seconds()
        code = f"import runpy, sys; sys.path.insert(0, {str(ROOT)!r}); runpy.run_path({str(script)!r})"
        ended = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
        printed, _, name = ended.stdout.rpartition(SHOWN)
        if ended.returncode or not name.strip():
            raise RuntimeError(f"{script.name} failed:\n{ended.stdout}{ended.stderr}")
        shutil.copyfile(Path(folder) / name.strip(), picture)
        return Shown(printed.strip(), _seconds() - before)


def page(script: Path, shown: Shown | None) -> str:
    """Return the page of a script."""
    title, text, code = parts(script)
    found = f"# {title}\n\n{text}\n"
    if shown is not None:
        found += f"\n![{title}]({script.stem}.png)\n\n```text\n{shown.printed}\n```\n"
        found += f"\nThis took {shown.seconds:.0f} s of processor time, imports and pictures included.\n"
    return f"{found}\n## The script\n\n```python\n{code}\n```\n"


def parts(script: Path) -> tuple[str, str, str]:
    """Return title, text and code of a script: the first line and the rest of its docstring, and what follows it."""
    text = script.read_text()
    tree = ast.parse(text)
    title, _, rest = (ast.get_docstring(tree) or "").partition("\n")
    code = "\n".join(text.splitlines()[tree.body[0].end_lineno :])
    return title.rstrip("."), rest.strip(), code.strip()


def _entry(script: Path, shown: Shown | None) -> str:
    title, _, _ = parts(script)
    picture = "" if shown is None else f"[![{title}]({script.stem}.png)]({script.stem}.md)\n\n"
    return f"## [{title}]({script.stem}.md)\n\n{picture}"


def _list(entries: list[str]) -> str:
    text = "Small scripts, run when this site was built: each takes well under a minute. Errors are estimated."
    toctree = "\n".join(script.stem for script in SCRIPTS)
    return f"# Gallery\n\n{text}\n\n{''.join(entries)}```{{toctree}}\n:hidden:\n\n{toctree}\n```\n"


def _version(script: Path) -> str:
    """Return a fingerprint of a script and of the package."""
    files = [script, *sorted((ROOT / "ngcell").rglob("*.py")), *sorted((ROOT / "cases").rglob("*.toml"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
