"""Case files in, case files out: TOML text to a checked case and back."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

import tomli_w
from pydantic import ValidationError

from ngcell.errors import CaseError
from ngcell.scene.catalogue import find_case
from ngcell.scene.complaint import CaseText, complaints
from ngcell.scene.kinds import AnyCase, kind_of_case
from ngcell.scene.lines import key_lines
from ngcell.scene.overrides import apply_overrides

_POSITION = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


def read_case(path_or_name: str | Path, overrides: Sequence[str] = ()) -> AnyCase:
    """Read and check a case file.

    Parameters
    ----------
    path_or_name : str or Path
        A TOML file, a folder that holds a `case.toml`, or the name of a case that comes with ngcell.
    overrides : sequence of str
        ``key=value`` with a dotted key and a TOML value (or a bare string), in place of the file's values.

    Returns
    -------
    Case or BodyCase
        The checked case, of a tissue or of user-defined bodies, with every default filled in.

    Raises
    ------
    CaseError
        The file cannot be read or is no case; one line for each mistake.
    """
    file = find_case(path_or_name)
    text = _text(file)
    table, overridden = apply_overrides(_parsed(text, file), overrides)
    try:
        return kind_of_case(table).model_validate(table)
    except ValidationError as error:
        case_text = CaseText(str(file), table, key_lines(text), tuple(overridden))
        raise CaseError("\n".join(complaints(error, case_text))) from None


def resolved_toml(case: AnyCase) -> str:
    """Return the text of a case file that says everything, defaults included, and reads back equal.

    Notes
    -----
    TOML has no "nothing": an optional number that the solver is left to choose does not appear.
    """
    return tomli_w.dumps(case.model_dump(mode="json", exclude_none=True))


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = error.strerror or error
        raise CaseError(f"{file}: cannot be read ({reason}); allowed: a readable TOML file") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{file}: byte {error.start} is not UTF-8; allowed: a TOML file in UTF-8") from error


def _parsed(text: str, file: Path) -> dict[str, object]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason, position = str(error), _POSITION.search(str(error))
        line = position[1] if position and position[1] else len(text.splitlines())
        column = f", column {position[2]}" if position and position[2] else ""
        told = _POSITION.sub("", reason).splitlines()[0]
        shown = text.splitlines()[int(line) - 1].strip() if text.strip() else ""
        raise CaseError(f"{file}:{line}: not TOML{column}: {told}: {shown}; allowed: key = value") from None
