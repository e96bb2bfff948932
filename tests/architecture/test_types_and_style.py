"""mypy, strict as `pyproject.toml` sets it, and ruff have nothing to say."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


COMMANDS = {
    "mypy": ("mypy", "--no-error-summary"),
    "ruff": ("ruff", "check", "--output-format=concise", "--quiet", "."),
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_there_is_no_finding(command: tuple[str, ...]) -> None:
    run = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True)
    findings = [line for line in (run.stdout + run.stderr).splitlines() if ": note: " not in line]
    shown = "\n".join(findings[:20])
    assert run.returncode == 0 and not findings, f"{len(findings)} findings of {command[0]}:\n{shown}"
