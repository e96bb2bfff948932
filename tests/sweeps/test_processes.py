"""Sweeps that really run: processes that are killed without warning, and workers started by hand."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import psutil
import pytest
from matplotlib.image import imread

from ngcell.errors import OutputError
from ngcell.report import write_report
from ngcell.sweeps.options import SweepOptions
from ngcell.sweeps.sweep import Sweep, read_sweep
from ngcell.sweeps.table import PROVENANCE
from ngcell.sweeps.task import Task
from tests.sweeps.conftest import SMALL, pretend

CASES = 6


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, pandas.DataFrame]:
    """The folder of a study, and its table when nothing is killed."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file = folder / "study.toml"
    file.write_text(f"{SMALL}[axes]\ntissue.wall = [0.08, 0.1, 0.12]\nmaterial.c1 = [0.5, 1.0]\n")
    runs = Sweep(file, folder / "out", SweepOptions(workers=2))
    for _ in runs:
        pass
    assert runs.computed == CASES and runs.certified
    return folder, runs.table()


def test_each_case_has_a_small_picture_which_the_report_shows(undisturbed):
    folder, _ = undisturbed
    files = sorted((folder / "out" / "pictures").iterdir())
    assert [file.name for file in files] == [f"case_{number:06d}.png" for number in range(CASES)]
    pictures = [imread(file) for file in files]
    assert {picture.shape[1] for picture in pictures} == {640} and all(file.stat().st_size < 80_000 for file in files)
    assert np.abs(pictures[0] - pictures[-1]).max() > 0.1  # a thin wall and a thick one
    page = write_report([folder / "out"]).file.read_text()
    assert page.count("<img") == CASES and "Tissues of 6 of 6 cases" in page and "wall 0.12, c1 1" in page


def test_as_many_cases_as_asked_have_a_picture_and_a_later_table_keeps_them(undisturbed, tmp_path):
    folder, expected = undisturbed
    for again in range(2):
        runs = Sweep(folder / "study.toml", tmp_path / "out", SweepOptions(workers=1, pictures=2))
        for _ in runs:
            pass
        assert runs.computed == (0 if again else CASES)
        names = [file.name for file in sorted((tmp_path / "out" / "pictures").iterdir())]
        assert names == ["case_000000.png", "case_000005.png"]
    pandas.testing.assert_frame_equal(numbers(runs.table()), numbers(expected))


def numbers(table: pandas.DataFrame) -> pandas.DataFrame:
    return table.drop(columns=list(PROVENANCE))


@contextmanager
def started(*arguments: str) -> Iterator[psutil.Popen]:
    """Start the command; whatever it has started is gone at the end."""
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    process = psutil.Popen([sys.executable, "-m", *arguments], **streams)
    try:
        yield process
    finally:
        family = [process, *(process.children(recursive=True) if process.is_running() else [])]
        for one in family:
            if one.is_running():
                one.kill()
        process.wait()


def until(question: Callable[[], object], seconds: float = 60.0) -> object:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := question():
            return found
        time.sleep(0.02)
    raise AssertionError("nothing came of it")


def results(folder: Path) -> list[Path]:
    return list(folder.rglob("store/*/*.json"))


def runs_of(process: psutil.Popen) -> list[psutil.Process]:
    """Return the processes of single cases."""
    return [one for one in process.children(recursive=True) if "case_run" in " ".join(_words(one))]


def workers_of(process: psutil.Popen) -> list[psutil.Process]:
    return [one.parent() for one in runs_of(process)]


def _words(process: psutil.Process) -> list[str]:
    try:
        return list(process.cmdline())
    except psutil.Error:
        return []


def is_gone(process: psutil.Process) -> bool:
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


def test_a_driver_that_is_killed_leaves_nothing_behind_and_the_next_goes_on(undisturbed, tmp_path):
    folder, expected = undisturbed
    words = ("ngcell", "sweep", str(folder / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "2")
    with started(*words) as driver:
        until(lambda: len(results(tmp_path)) >= 2 and runs_of(driver))
        others = driver.children(recursive=True)
        os.kill(driver.pid, signal.SIGKILL)
        driver.wait()
        until(lambda: all(is_gone(one) for one in others))
    kept = {path: path.stat().st_mtime_ns for path in results(tmp_path)}
    assert 2 <= len(kept) < CASES
    runs = Sweep(folder / "study.toml", tmp_path / "out", SweepOptions(workers=1))
    for _ in runs:
        pass
    assert runs.computed == CASES - len(kept) and runs.reused == len(kept)
    assert all(path.stat().st_mtime_ns == before for path, before in kept.items())
    pandas.testing.assert_frame_equal(numbers(runs.table()), numbers(expected))


@pytest.mark.parametrize("victims", [workers_of, runs_of], ids=["worker", "run"])
def test_what_is_killed_costs_its_one_case_which_is_tried_again(victims, undisturbed, tmp_path):
    folder, expected = undisturbed
    words = ("ngcell", "sweep", str(folder / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "2")
    with started(*words) as driver:
        victim = until(lambda: victims(driver))[0]
        orphans = victim.children(recursive=True)
        os.kill(victim.pid, signal.SIGKILL)
        said, _ = driver.communicate(timeout=120)
        assert driver.returncode == 0, said
        assert all(is_gone(one) for one in orphans)
    table = read_sweep(tmp_path / "out")
    pandas.testing.assert_frame_equal(numbers(table), numbers(expected))
    assert sorted(table.groupby("case")["attempts"].first()) == [1] * (CASES - 1) + [2]


def thin_ones_kill_their_worker(task: Task) -> dict[str, Any]:
    if "wall = 0.08" in task.text:
        os._exit(1)
    return pretend(task)


def test_a_case_that_kills_each_worker_that_takes_it_costs_itself_only(undisturbed, tmp_path):
    folder, _ = undisturbed
    options = SweepOptions(workers=1, function=thin_ones_kill_their_worker)
    runs = Sweep(folder / "study.toml", tmp_path / "out", options)
    for _ in runs:
        pass
    assert runs.outcomes == {"killed": 2, "certified": 4}
    rows = runs.table().groupby("case").first()
    assert set(rows[rows["tissue.wall"] == 0.08]["attempts"]) == {2}


def test_ctrl_c_keeps_what_has_ended_and_writes_its_table(undisturbed, tmp_path):
    folder, expected = undisturbed
    words = ("ngcell", "sweep", str(folder / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "1")
    with started(*words) as driver:
        until(lambda: results(tmp_path))
        others = driver.children(recursive=True)
        driver.send_signal(signal.SIGINT)
        said, _ = driver.communicate(timeout=60)
        until(lambda: all(is_gone(one) for one in others))
    assert driver.returncode == 4
    table = read_sweep(tmp_path / "out")
    ended = table["case"].nunique()
    assert 1 <= ended < CASES
    assert f"stopped by Ctrl-C; {ended} of {CASES} cases have ended" in said.splitlines()[-1]
    same = expected[expected["case"].isin(table["case"])].reset_index(drop=True)
    pandas.testing.assert_frame_equal(numbers(table), numbers(same))


def test_a_scheduler_and_two_workers_started_by_hand_serve_a_sweep(undisturbed, tmp_path):
    folder, expected = undisturbed
    address_file, here = tmp_path / "scheduler.json", ("--host", "127.0.0.1", "--no-dashboard")
    given = ("--scheduler-file", str(address_file))
    worker = ("distributed.cli.dask_worker", *given, *here, "--nthreads", "1", "--local-directory", str(tmp_path))
    with started("distributed.cli.dask_scheduler", *given, *here, "--port", "0"):
        until(lambda: address_file.exists() and "address" in address_file.read_text(encoding="utf-8"))
        with started(*worker, "--name", "a"), started(*worker, "--name", "b"):
            address = pandas.read_json(address_file, typ="series")["address"]
            runs = Sweep(folder / "study.toml", tmp_path / "out", SweepOptions(scheduler=address))
            for _ in runs:
                pass
    assert runs.computed == CASES
    pandas.testing.assert_frame_equal(numbers(runs.table()), numbers(expected))


def test_a_sweep_whose_last_worker_is_killed_keeps_what_has_ended(undisturbed, tmp_path):
    folder, expected = undisturbed
    address_file, here = tmp_path / "scheduler.json", ("--host", "127.0.0.1", "--no-dashboard")
    given = ("--scheduler-file", str(address_file))
    worker = ("distributed.cli.dask_worker", *given, *here, "--nthreads", "1", "--local-directory", str(tmp_path))
    with started("distributed.cli.dask_scheduler", *given, *here, "--port", "0"):
        until(lambda: address_file.exists() and "address" in address_file.read_text(encoding="utf-8"))
        address = pandas.read_json(address_file, typ="series")["address"]
        with started(*worker) as only:
            runs = Sweep(folder / "study.toml", tmp_path / "out", SweepOptions(scheduler=address, wait=0.05))
            with pytest.raises(OutputError, match="no worker for 0.05 minutes"):
                for ended in runs:
                    if ended.done == 2:
                        for process in [only, *only.children(recursive=True)]:  # its nanny first: it starts no other
                            process.kill()
        kept = runs.computed
        assert 2 <= kept < CASES and read_sweep(tmp_path / "out")["case"].nunique() == kept
    again = Sweep(folder / "study.toml", tmp_path / "out", SweepOptions(workers=1))
    for _ in again:
        pass
    assert again.reused == kept
    pandas.testing.assert_frame_equal(numbers(again.table()), numbers(expected))


def test_runs_that_fail_are_rows_with_their_outcome(tmp_path):
    file = tmp_path / "study.toml"
    keys = "load.displacement = [[0.1, 0.0], [0.1, -1.72], [0.2, 0.0]]"
    head = SMALL.replace("load.displacement = [0.1, 0.0]\n", "")
    file.write_text(f"outputs = ['energy']\n{head}[axes]\n{keys}\n")
    runs = Sweep(file, tmp_path / "out", SweepOptions(workers=1))
    for _ in runs:
        pass
    rows = runs.table().groupby("case").first()
    assert rows["outcome"][0] == "certified" and rows["outcome"][2] == "certified"
    assert rows["outcome"][1] in {"tied-failed", "release-failed", "out-of-iterations", "refused", "not-certified"}
    assert rows["detail"][1]


@pytest.mark.parametrize(
    ("head", "memory", "outcome"), [("minutes = 0.0001\n", None, "out-of-time"), ("", 0.02, "out-of-memory")]
)
def test_time_and_memory_end_a_run_with_a_name(head, memory, outcome, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(f"{head}{SMALL}[axes]\ntissue.wall = [0.1]\n")
    runs = Sweep(file, tmp_path / "out", SweepOptions(workers=1, memory=memory))
    for _ in runs:
        pass
    rows = runs.table()
    assert set(rows["outcome"]) == {outcome}, rows["detail"][0]
    assert not rows["certified"].any() and rows["detail"][0]
