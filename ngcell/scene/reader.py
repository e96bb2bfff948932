"""Case files in, case files out: TOML text to a checked case and back."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import tomli_w
from pydantic import ValidationError

from ngcell.errors import CaseError
from ngcell.scene.bodies import BodyScene
from ngcell.scene.catalogue import find_case
from ngcell.scene.complaint import CaseText, complaints
from ngcell.scene.inheritance import CaseTable, read_table
from ngcell.scene.kinds import AnyCase, kind_of_case
from ngcell.scene.overrides import Setting, settings_of, title_of_changed, with_settings
from ngcell.scene.section import validated
from ngcell.scene.written_bodies import written_bodies

#: Keys that say how a scene is solved, or nothing about it: expected numbers hold whatever they are.
_NOT_OF_THE_SCENE = {"title", "source", "strategy", "steps", "contact", "mesh", "accuracy", "estimate_error"}


def read_case(path_or_name: str | Path, overrides: Sequence[str] = ()) -> AnyCase:
    """Read and check a case file.

    Parameters
    ----------
    path_or_name : str or Path
        A TOML file, a folder that holds a `case.toml`, or the name of a case that comes with ngcell. Its key `extends`
        takes over what another case says.
    overrides : sequence of str
        ``key=value`` with a dotted key and a TOML value (or a bare string), in place of the file's values. The file's
        expected numbers are dropped where an override makes it another scene, unless one sets them as well, and its
        title is followed by what was set, unless one sets it.

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
    try:
        said, settings = read_table(file), settings_of(overrides)
        return variant(str(file), said, (*settings, *title_of_changed(said.table, settings)))
    except RecursionError:
        raise CaseError(f"{file}: tables or lists are nested too deep; allowed: the keys of a case") from None


def variant(name: str, said: CaseTable, settings: Sequence[Setting]) -> AnyCase:
    """Return the case that a file says, with values set beside it; see `read_case`.

    Parameters
    ----------
    name : str
        How messages name the file.
    said : CaseTable
        What it says; left unchanged.
    settings : sequence of Setting
        Values in place of the file's.
    """
    before = said.table
    if _is_another_scene(settings):
        before = {key: value for key, value in before.items() if key != "expected"}
    table = with_settings(before, settings)
    try:
        return validated(kind_of_case(table), table)
    except ValidationError as error:
        overridden = {setting.path: setting.place or f"{name}: --set" for setting in settings}
        raise CaseError("\n".join(complaints(error, CaseText(name, table, said.places, overridden)))) from None


def case_title(file: Path) -> str:
    """Return the title of a case file, which is not checked."""
    return str(read_table(file).table.get("title", ""))


def resolved_toml(case: AnyCase | BodyScene) -> str:
    """Return the text of a case file that says everything, defaults included, and reads back equal.

    Of a scene from Python the text says what can be said, and does not read back.

    Notes
    -----
    TOML has no "nothing": an optional number that the solver is left to choose does not appear. An object that a script
    handed over, and that no case file can say, appears by the name of its class.
    """
    if isinstance(case, BodyScene):
        return written_bodies(case)
    return tomli_w.dumps(case.model_dump(mode="json", exclude_none=True))


def _is_another_scene(settings: Sequence[Setting]) -> bool:
    keys = {setting.path[0] for setting in settings}
    return bool(keys - _NOT_OF_THE_SCENE) and "expected" not in keys
