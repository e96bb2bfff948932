"""What a page tells its reader to do, done: files saved, commands run, scripts executed, in the order of the page."""

from __future__ import annotations

import contextlib
import io
import re
import runpy
import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from ngcell.cli import ngcell

FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
#: How a page says under which name a block is to be saved.
SAVED = re.compile(r"(?:Save|and) this as\s+`([^`]+)`")
#: What is done once, by the test of the release: `tests/docs/test_release.py`.
INSTALLING = ("python3.11 -m venv", ". .venv/bin/activate", "pip install")


@dataclass
class Page:
    """A page, and a folder to follow it in.

    Attributes
    ----------
    path, folder : Path
        The page, and the folder.
    smaller : function
        What scripts, cases and commands are passed through, so that they take less time.
    """

    path: Path
    folder: Path
    smaller: Callable[[str], str] = str
    names: dict[str, Any] = field(default_factory=dict)

    def follow(self) -> Iterator[tuple[str, str]]:
        """Do what the page says; yield what each run block printed, and what the page says that it prints."""
        text, printed = self.path.read_text(), ""
        for block in FENCE.finditer(text):
            language, code = block.groups()
            saved = SAVED.findall(text[: block.start()].rstrip().rpartition("\n\n")[2])
            if saved:
                (self.folder / saved[-1]).write_text(self.smaller(code))
            elif language == "sh":
                printed = "".join(self._run(line) for line in code.splitlines())
                yield printed, ""
            elif language == "python":
                printed = self._execute(code)
                yield printed, ""
            elif language == "text":
                yield printed, code

    def _run(self, line: str) -> str:
        if line.startswith(INSTALLING):
            return ""
        program, *arguments = shlex.split(self.smaller(line), comments=True)
        with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.chdir(self.folder):
            if program == "python":
                runpy.run_path(arguments[0])
                return printed.getvalue()
            answer = CliRunner().invoke(ngcell, arguments)
        assert program == "ngcell" and answer.exit_code == 0, f"{line}\n{answer.output}{answer.exception}"
        return answer.stdout

    def _execute(self, code: str) -> str:
        with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.chdir(self.folder):
            exec(self.smaller(code), self.names)
        return printed.getvalue()

