"""Build the wheel and the source distribution, install them and solve: python -m tools.docs release

The wheel is built from the source distribution, so that both are tried. It is installed into an environment of its own,
beside the dependencies of this one, and run in a folder outside the repository. Nothing takes the network.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from tools.commands import described
from tools.docs.extra import check_extra
from tools.places import ROOT

#: What is run outside the repository, in seconds.
TRIED = (
    ("--version",),
    ("check", "shear-empty-3x3"),
    ("solve", "shear-empty-3x3", "--set", "accuracy=inf", "--set", "load.levels=1", "--out", "out"),
)


def built(out: Path) -> tuple[Path, Path]:
    """Build a source distribution and from it a wheel into an empty folder; return both."""
    check_extra("test", "build", "hatchling")
    _run([sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(ROOT)], ROOT)
    (source,), (wheel,) = out.glob("*.tar.gz"), out.glob("*.whl")
    return source, wheel


def installed(wheel: Path, folder: Path) -> Path:
    """Install a wheel into a new environment, beside the dependencies of this one; return its programs' folder."""
    _run([sys.executable, "-m", "venv", "--without-pip", str(folder)], ROOT)
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", str(python), "--quiet", "--disable-pip-version-check"]
    _run([*pip, "install", "--no-deps", "--no-index", str(wheel)], ROOT)
    (packages,) = folder.glob("lib/python*/site-packages")
    dependencies = [path for path in sys.path if Path(path).name in {"site-packages", "dist-packages"}]
    (packages / "dependencies.pth").write_text("\n".join(dependencies) + "\n")
    return python.parent


def tried(programs: Path, folder: Path) -> list[str]:
    """Run the installed program in a folder; return where the package is, and what each command printed."""
    place = [str(programs / "python"), "-c", "import ngcell; print(ngcell.__file__)"]
    return [_run(command, folder) for command in (place, *([str(programs / "ngcell"), *told] for told in TRIED))]


def _run(command: list[str], folder: Path) -> str:
    """Run a command outside of what this process imports from; return what it printed."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if ended.returncode:
        raise RuntimeError(f"{' '.join(command)} ended with {ended.returncode}:\n{ended.stdout}{ended.stderr}")
    return ended.stdout


@described(__doc__)
@click.option("--out", type=click.Path(path_type=Path), default=ROOT / "dist", help="Empty folder of the files.")
def command(out: Path) -> None:
    source, wheel = built(out)
    with TemporaryDirectory() as folder:
        for printed in tried(installed(wheel, Path(folder) / "environment"), Path(folder)):
            click.echo(printed.rstrip())
    click.echo(f"{source}\n{wheel}")
