"""Where case files are: a path, or the name of a case that comes with ngcell."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path

from ngcell.errors import CaseError

_PACKAGE = Path(__file__).parents[1]
#: The wheel has the cases inside the package; in a source checkout they stand beside it.
_SHELVES = (_PACKAGE / "_cases", _PACKAGE.parent / "cases")


def shipped_cases() -> dict[str, Path]:
    """Return the case files that come with ngcell, by name."""
    shelf = next((shelf for shelf in _SHELVES if shelf.is_dir()), None)
    if shelf is None:
        return {}
    files = [*shelf.glob("*.toml"), *shelf.glob("*/case.toml")]
    return {case_name(file): file for file in sorted(files)}


def find_study(path_or_name: str | Path) -> Path:
    """Return the file of a study that a path, or the name of one that comes with ngcell, means."""
    path = Path(path_or_name)
    return path if _holds(path, Path.is_file) else shipped_studies().get(str(path_or_name), path)


def shipped_studies() -> dict[str, Path]:
    """Return the files of studies that come with ngcell, by name."""
    return {file.stem: file for shelf in _SHELVES[::-1] for file in sorted((shelf / "studies").glob("*.toml"))}


def find_case(path_or_name: str | Path) -> Path:
    """Return the case file that a path, a folder with a `case.toml` or a shipped name means.

    Raises
    ------
    CaseError
        There is no such file, and no shipped case of that name.
    """
    path = Path(path_or_name)
    found = case_in(path)
    if found is not None:
        return found
    shipped = shipped_cases()
    if str(path_or_name) in shipped:
        return shipped[str(path_or_name)]
    if _holds(path, Path.is_dir):
        raise CaseError(
            f"{path_or_name}: a folder without a case.toml; allowed: the path of a TOML file, a folder with a "
            f"case.toml, or one of {', '.join(shipped)}"
        )
    near = get_close_matches(path.stem, shipped, n=1)
    raise CaseError(
        f"{path_or_name}: no such case file"
        + (f"; did you mean {near[0]}?" if near else "")
        + f"; allowed: the path of a TOML file, or one of {', '.join(shipped)}"
    )


def case_in(path: Path) -> Path | None:
    """Return the case file that a path, or a folder with a `case.toml`, means; None if there is none."""
    return next((file for file in (path, path / "case.toml") if _holds(file, Path.is_file)), None)


def _holds(path: Path, question: Callable[[Path], bool]) -> bool:
    try:
        return question(path)
    except OSError:  # such as a name that is too long for the file system
        return False


def case_name(file: Path) -> str:
    """Return the short name of a case file: its stem, or its folder's name for a `case.toml`."""
    return file.resolve().parent.name if file.name == "case.toml" else file.stem
