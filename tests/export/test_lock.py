"""A folder belongs to one run at a time, and a result to whoever made it, until he gives it away."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from ngcell.errors import OutputError
from ngcell.export import ResultFolder, read_summary
from ngcell.export.lock import LOCK, FolderLock


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}


def test_a_second_run_is_refused_in_one_line(tmp_path, make_record):
    with ResultFolder(tmp_path) as folder:
        folder.accept(make_record(1))
        before = contents(tmp_path)
        for force in (False, True):
            with pytest.raises(OutputError, match=r"is in use: process \d+ on .*choose another folder$") as refusal:
                ResultFolder(tmp_path, force=force).__enter__()
            assert "\n" not in str(refusal.value)
        assert contents(tmp_path) == before
    assert not (tmp_path / LOCK).exists()


def test_the_lock_ends_with_its_process(tmp_path):
    program = (
        "import sys, os\nfrom pathlib import Path\nfrom ngcell.export.lock import FolderLock\n"
        "lock = FolderLock(Path(sys.argv[1]))\nprint('held', flush=True)\nsys.stdin.read()\n"
    )
    holder = subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout is not None and holder.stdout.readline() == "held\n"
    with pytest.raises(OutputError, match=f"process {holder.pid} on "):
        FolderLock(tmp_path)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert (tmp_path / LOCK).exists()
    FolderLock(tmp_path).release()
    assert not (tmp_path / LOCK).exists()


def test_a_lock_that_was_removed_is_taken_anew(tmp_path):
    first = FolderLock(tmp_path)
    (tmp_path / LOCK).unlink()
    second = FolderLock(tmp_path)
    with pytest.raises(OutputError, match="in use"):
        FolderLock(tmp_path)
    second.release()
    first.release()


def test_accepted_steps_are_replaced_by_force_only(tmp_path, make_record):
    with ResultFolder(tmp_path) as folder:
        folder.accept(make_record(1))
        folder.finish({"certified": True, "accepted_steps": 1})
    before = contents(tmp_path)
    with pytest.raises(OutputError, match="--force"):
        ResultFolder(tmp_path).__enter__()
    assert contents(tmp_path) == before


@pytest.mark.parametrize("ending", [RuntimeError, KeyboardInterrupt, None])
def test_a_forced_run_without_an_accepted_step_leaves_the_earlier_one(tmp_path, make_record, ending):
    with ResultFolder(tmp_path, case_text="a = 1") as folder:
        folder.accept(make_record(1))
        folder.finish({"certified": True, "accepted_steps": 1})
    before = contents(tmp_path)
    if ending is None:
        with ResultFolder(tmp_path, case_text="a = 2", force=True) as folder:
            folder.draw(certified=False)
            folder.finish({"certified": False, "accepted_steps": 0})
    else:
        with pytest.raises(ending), ResultFolder(tmp_path, case_text="a = 2", force=True):
            raise ending
    assert contents(tmp_path) == before


def test_a_run_without_an_accepted_step_gives_way_to_any(tmp_path, make_record):
    with ResultFolder(tmp_path, case_text="a = 1") as folder:
        folder.finish({"certified": False, "accepted_steps": 0})
    with ResultFolder(tmp_path, case_text="a = 2") as folder:
        folder.accept(make_record(1))
    assert read_summary(tmp_path)["accepted_steps"] == 1
    assert (tmp_path / "case.toml").read_text() == "a = 2"


def test_a_full_disk_is_no_reason_not_to_hold_a_folder(tmp_path, monkeypatch):
    def full(handle, text):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ngcell.export.lock.os.write", full)
    lock = FolderLock(tmp_path)
    with pytest.raises(OutputError, match="in use: another process"):
        FolderLock(tmp_path)
    lock.release()
    assert not (tmp_path / LOCK).exists()
