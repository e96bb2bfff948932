import csv
import errno
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
import pyvista

from ngcell.errors import OutputError
from ngcell.export import ResultFolder, read_last_snapshot, read_summary, write_summary


def steps(folder, table="history.csv"):
    with open(folder / table, newline="") as file:
        return [int(row["step"]) for row in csv.DictReader(file)]


def test_a_finished_run_leaves_everything(tmp_path, make_record, wall_records, make_snapshot):
    out = tmp_path / "results" / "shear"
    with ResultFolder(out, case_text="[tissue]\n") as folder:
        folder.accept(make_record(1), wall_records(1), make_snapshot(1))
        folder.accept(make_record(2))
        folder.accept(make_record(3), wall_records(3), make_snapshot(3))
        folder.finish({"certified": True, "title": "two rings"})
    assert {path.name for path in out.iterdir()} == {
        "case.toml", "history.csv", "walls.csv", "cells.csv", "tissue.pvd", "tissue_0000.vtu", "tissue_0001.vtu",
        "walls_0000.vtu", "walls_0001.vtu", "summary.json", "tissue.png", "gap.png", "debonding.png",
    }  # fmt: skip
    assert (out / "case.toml").read_text() == "[tissue]\n"
    assert steps(out) == [1, 2, 3]
    assert steps(out, "walls.csv") == [1, 3]
    summary = read_summary(out)
    assert (summary["program"], summary["status"], summary["certified"]) == ("ngcell", "finished", True)


def test_a_killed_run_is_recognised_and_readable(tmp_path):
    program = textwrap.dedent("""
        import os, signal, sys
        from pathlib import Path
        sys.path.insert(0, sys.argv[2])
        from conftest import facing_walls, ring_bodies
        from ngcell.export import ResultFolder
        from ngcell.results.record import StepRecord, WallRecord
        from ngcell.results.snapshot import Snapshot
        with ResultFolder(Path(sys.argv[1])) as folder:
            for step in (1, 2):
                numbers = [0.0] * 11
                folder.accept(
                    StepRecord(step, "released", step / 2, step / 10, *numbers, 1, 1, 0.1, True),
                    [WallRecord(step, step / 2, 0, 1, 0.1, 0.05, 0.0, 1.0, True, 0, 0.2)],
                    Snapshot(step, step / 2, step / 10, ring_bodies(0.1), facing_walls(0.1)),
                )
            os.kill(os.getpid(), signal.SIGKILL)
    """)
    out = tmp_path / "out"
    here = Path(__file__).parent
    killed = subprocess.run([sys.executable, "-c", program, out, here], check=False)
    assert killed.returncode == -signal.SIGKILL
    summary = read_summary(out)
    assert (summary["status"], summary["accepted_steps"], summary["load_factor"]) == ("running", 2, 1.0)
    assert steps(out) == steps(out, "walls.csv") == [1, 2]
    assert pyvista.get_reader(out / "tissue.pvd").time_values == [0.1, 0.2]
    assert read_last_snapshot(out)[0].step == 2


def test_a_run_that_ends_by_an_error_says_why(tmp_path, make_record):
    with pytest.raises(RuntimeError), ResultFolder(tmp_path) as folder:
        folder.accept(make_record(1))
        raise RuntimeError("elements inverted")
    summary = read_summary(tmp_path)
    assert (summary["status"], summary["reason"], summary["accepted_steps"]) == (
        "stopped", "elements inverted", 1,
    )  # fmt: skip


def test_an_earlier_result_is_replaced_and_nothing_else(tmp_path, make_record, make_snapshot):
    for count in (3, 1):
        with ResultFolder(tmp_path, force=True) as folder:
            for step in range(count):
                folder.accept(make_record(step), (), make_snapshot(step))
        (tmp_path / "notes.txt").write_text("mine")
    assert steps(tmp_path) == [0]
    assert sorted(path.name for path in tmp_path.glob("*.vtu")) == ["tissue_0000.vtu", "walls_0000.vtu"]
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["notes.txt", "history.csv", "summary.json"])
def test_a_folder_of_someone_else_is_not_touched(tmp_path, name):
    (tmp_path / name).write_text("{}")
    with pytest.raises(OutputError, match="is not empty and holds no ngcell result"), ResultFolder(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "{}"


def test_a_run_killed_before_its_first_file_can_be_repeated(tmp_path):
    (tmp_path / ".summary.json.tmp").write_text("{")
    with ResultFolder(tmp_path):
        pass
    assert not (tmp_path / ".summary.json.tmp").exists()


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "out", tmp_path / "file"):
        with pytest.raises(OutputError, match=f"cannot use {path} as the result folder: .*; choose another"):
            ResultFolder(path).__enter__()


@pytest.mark.parametrize("full", ["walls.csv", "history.csv", "tissue_0001.vtu", "walls_0001.vtu", "tissue.pvd"])
def test_a_step_that_a_full_disk_refuses_is_taken_back(
    tmp_path, make_record, wall_records, make_snapshot, monkeypatch, full
):
    with ResultFolder(tmp_path) as folder:
        folder.accept(make_record(1), wall_records(1), make_snapshot(1))
        _fill_disk(monkeypatch, full)
        with pytest.raises(OutputError) as refusal:
            folder.accept(make_record(2), wall_records(2), make_snapshot(2))
        monkeypatch.undo()
    message = str(refusal.value)
    assert f"cannot write {tmp_path / full}: No space left on device" in message
    assert f"1 accepted step up to load factor 0.05 is kept in {tmp_path}" in message
    assert "\n" not in message
    assert steps(tmp_path) == steps(tmp_path, "walls.csv") == [1]
    assert pyvista.get_reader(tmp_path / "tissue.pvd").time_values == [0.1]
    assert len(list(tmp_path.glob("*.vtu"))) == 2


def test_pictures_that_cannot_be_written_leave_the_steps(tmp_path, make_record, make_snapshot, monkeypatch):
    with pytest.raises(OutputError, match=r"gap\.png: No space .*; 1 accepted step"):
        with ResultFolder(tmp_path) as folder:
            folder.accept(make_record(1), (), make_snapshot(1))
            _fill_disk(monkeypatch, "gap.png")
            folder.finish({"certified": True})
    assert steps(tmp_path) == [1]
    assert read_summary(tmp_path)["status"] == "stopped"


def test_a_result_without_steps_can_be_finished(tmp_path):
    write_summary(tmp_path, {"program": "ngcell"})
    with ResultFolder(tmp_path) as folder:
        folder.finish({"certified": False})
    assert not list(tmp_path.glob("*.png"))


def _fill_disk(monkeypatch, name):
    """Refuse to bring the file of this name to disk, at the last moment."""
    fsync, replace = os.fsync, os.replace
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def refuse_sync(descriptor):
        if os.path.basename(os.readlink(f"/proc/self/fd/{descriptor}")) == name:
            raise full
        fsync(descriptor)

    def refuse_replace(source, target):
        if os.path.basename(target) == name:
            raise full
        replace(source, target)

    monkeypatch.setattr(os, "fsync", refuse_sync)
    monkeypatch.setattr(os, "replace", refuse_replace)
