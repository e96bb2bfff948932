"""Sweeps that really run: processes that are killed without warning, and workers started by hand."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import distributed
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
from tests.sweeps.conftest import SMALL, SMALLER, pretend

CASES = 3


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, scheduler: str) -> tuple[Path, pandas.DataFrame]:
    """The folder of a study, and its table when nothing is killed."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file = folder / "study.toml"
    file.write_text(f"{SMALLER}[axes]\ntissue.wall = [0.08, 0.1, 0.12]\n")
    runs = swept(file, folder / "out", scheduler=scheduler)
    assert runs.computed == CASES and runs.certified
    return folder, runs.table()


def swept(file: Path, out: Path, **options: Any) -> Sweep:
    """Run a sweep to its end."""
    runs = Sweep(file, out, SweepOptions(**options))
    for _ in runs:
        pass
    return runs


def test_each_case_has_a_small_picture_which_the_report_shows(undisturbed):
    folder, _ = undisturbed
    files = sorted((folder / "out" / "pictures").iterdir())
    assert [file.name for file in files] == [f"case_{number:06d}.png" for number in range(CASES)]
    pictures = [imread(file) for file in files]
    assert {picture.shape[1] for picture in pictures} == {640} and all(file.stat().st_size < 80_000 for file in files)
    assert np.abs(pictures[0] - pictures[-1]).max() > 0.1  # a thin wall and a thick one
    page = write_report([folder / "out"]).file.read_text()
    assert page.count("<img") == CASES and f"Tissues of {CASES} of {CASES} cases" in page and "wall 0.12" in page


def pretend_with_a_picture(task: Task) -> dict[str, Any]:
    return {**pretend(task), **({"picture": b64encode(task.key.encode()).decode()} if task.picture else {})}


def test_as_many_cases_as_asked_have_a_picture_and_a_later_table_keeps_them(undisturbed, scheduler, tmp_path):
    folder, _ = undisturbed
    told = []
    for again in range(2):
        options = {"scheduler": scheduler, "pictures": 2, "function": pretend_with_a_picture}
        runs = swept(folder / "study.toml", tmp_path / "out", **options)
        assert runs.computed == (0 if again else CASES)
        files = sorted((tmp_path / "out" / "pictures").iterdir())
        assert [file.name for file in files] == ["case_000000.png", "case_000002.png"]
        told.append((runs.table(), [file.read_bytes() for file in files]))
    (first, pictures), (later, kept) = told
    pandas.testing.assert_frame_equal(later, first)
    assert kept == pictures == [key.encode() for key in first.groupby("case")["key"].first()[[0, 2]]]


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


#: A sweep that draws nothing.
UNSEEN = ("--pictures", "0")


def results(folder: Path) -> list[Path]:
    return list(folder.rglob("store/*/*.json"))


def runs_of(process: psutil.Popen) -> list[psutil.Process]:
    """Return the processes of single cases."""
    return [one for one in process.children(recursive=True) if "case_run" in " ".join(_words(one))]


def _words(process: psutil.Process) -> list[str]:
    try:
        return list(process.cmdline())
    except psutil.Error:
        return []


def is_gone(process: psutil.Process) -> bool:
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


def test_a_driver_that_is_killed_leaves_nothing_behind_and_the_next_goes_on(undisturbed, scheduler, tmp_path):
    folder, expected = undisturbed
    words = ("ngcell", "sweep", str(folder / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "2", *UNSEEN)
    with started(*words) as driver:
        until(lambda: len(results(tmp_path)) >= 1 and runs_of(driver))
        others = driver.children(recursive=True)
        os.kill(driver.pid, signal.SIGKILL)
        driver.wait()
        until(lambda: all(is_gone(one) for one in others))
    kept = {path: path.stat().st_mtime_ns for path in results(tmp_path)}
    assert 1 <= len(kept) < CASES
    runs = swept(folder / "study.toml", tmp_path / "out", scheduler=scheduler, pictures=0)
    assert runs.computed == CASES - len(kept) and runs.reused == len(kept)
    assert all(path.stat().st_mtime_ns == before for path, before in kept.items())
    pandas.testing.assert_frame_equal(numbers(runs.table()), numbers(expected))


def test_a_worker_and_a_run_that_are_killed_cost_their_one_case_each_which_is_tried_again(undisturbed, tmp_path):
    folder, expected = undisturbed
    words = ("ngcell", "sweep", str(folder / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "2", *UNSEEN)
    with started(*words) as driver:
        one, other = until(lambda: len(found := runs_of(driver)) == 2 and found)
        worker = one.parent()
        orphans = worker.children(recursive=True)
        for victim in (worker, other):
            os.kill(victim.pid, signal.SIGKILL)
        said, _ = driver.communicate(timeout=120)
        assert driver.returncode == 0, said
        assert all(is_gone(process) for process in orphans)
    table = read_sweep(tmp_path / "out")
    pandas.testing.assert_frame_equal(numbers(table), numbers(expected))
    assert sorted(table.groupby("case")["attempts"].first()) == [1] * (CASES - 2) + [2] * 2


def thin_ones_kill_their_worker(task: Task) -> dict[str, Any]:
    if "wall = 0.08" in task.text:
        os._exit(1)
    return pretend(task)


def test_a_case_that_kills_each_worker_that_takes_it_costs_itself_only(tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(f"{SMALL}[axes]\ntissue.wall = [0.1, 0.08, 0.12]\n")
    runs = swept(file, tmp_path / "out", workers=1, function=thin_ones_kill_their_worker)
    assert runs.outcomes == {"killed": 1, "certified": 2}
    rows = runs.table().groupby("case").first()
    assert set(rows[rows["tissue.wall"] == 0.08]["attempts"]) == {2}


def test_ctrl_c_keeps_what_has_ended_and_writes_its_table(undisturbed, tmp_path):
    folder, expected = undisturbed
    words = ("ngcell", "sweep", str(folder / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "1", *UNSEEN)
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
    _, expected = undisturbed
    file = tmp_path / "study.toml"
    file.write_text(f"{SMALLER}[axes]\ntissue.wall = [0.08, 0.12]\n")
    address_file, here = tmp_path / "scheduler.json", ("--host", "127.0.0.1", "--no-dashboard")
    given = ("--scheduler-file", str(address_file))
    worker = ("distributed.cli.dask_worker", *given, *here, "--nthreads", "1", "--local-directory", str(tmp_path))
    with started("distributed.cli.dask_scheduler", *given, *here, "--port", "0"):
        until(lambda: address_file.exists() and "address" in address_file.read_text(encoding="utf-8"))
        with started(*worker, "--name", "a"), started(*worker, "--name", "b"):
            address = pandas.read_json(address_file, typ="series")["address"]
            runs = swept(file, tmp_path / "out", scheduler=address, pictures=0)
    assert runs.computed == 2
    same = expected[expected["tissue.wall"] != 0.1].reset_index(drop=True)
    found, known = (numbers(table).drop(columns="case") for table in (runs.table(), same))
    pandas.testing.assert_frame_equal(found, known)


def test_a_sweep_whose_last_worker_is_killed_keeps_what_has_ended(undisturbed, scheduler, tmp_path):
    folder, expected = undisturbed
    address_file, here = tmp_path / "scheduler.json", ("--host", "127.0.0.1", "--no-dashboard")
    given = ("--scheduler-file", str(address_file))
    worker = ("distributed.cli.dask_worker", *given, *here, "--nthreads", "1", "--local-directory", str(tmp_path))
    with started("distributed.cli.dask_scheduler", *given, *here, "--port", "0"):
        until(lambda: address_file.exists() and "address" in address_file.read_text(encoding="utf-8"))
        address = pandas.read_json(address_file, typ="series")["address"]
        with started(*worker) as only:
            with distributed.Client(address) as client:
                client.wait_for_workers(1, timeout=60)  # the sweep would take one that comes late for none
            runs = Sweep(folder / "study.toml", tmp_path / "out", SweepOptions(scheduler=address, wait=0.05))
            with pytest.raises(OutputError, match="no worker for 0.05 minutes"):
                for ended in runs:
                    if ended.done == 2:
                        for process in [only, *only.children(recursive=True)]:  # its nanny first: it starts no other
                            process.kill()
        kept = runs.computed
        assert 2 <= kept < CASES and read_sweep(tmp_path / "out")["case"].nunique() == kept
    again = swept(folder / "study.toml", tmp_path / "out", scheduler=scheduler)
    assert again.reused == kept and again.computed == CASES - kept
    pandas.testing.assert_frame_equal(numbers(again.table()), numbers(expected))


def test_runs_that_fail_are_rows_with_their_outcome(tmp_path, scheduler):
    file = tmp_path / "study.toml"
    keys = "load.displacement = [[0.1, -1.72], [0.2, 0.0]]"
    head = SMALLER.replace("load.displacement = [0.1, 0.0]\n", "")
    file.write_text(f"outputs = ['energy']\n{head}[axes]\n{keys}\n")
    rows = swept(file, tmp_path / "out", scheduler=scheduler, pictures=0).table().groupby("case").first()
    assert rows["outcome"][1] == "certified"
    assert rows["outcome"][0] in {"tied-failed", "release-failed", "out-of-iterations", "refused", "not-certified"}
    assert rows["detail"][0]


@pytest.mark.parametrize(
    ("head", "memory", "outcome"), [("minutes = 0.0001\n", None, "out-of-time"), ("", 0.02, "out-of-memory")]
)
def test_time_and_memory_end_a_run_with_a_name(head, memory, outcome, tmp_path, scheduler):
    file = tmp_path / "study.toml"
    file.write_text(f"{head}{SMALL}[axes]\ntissue.wall = [0.1]\n")
    rows = swept(file, tmp_path / "out", scheduler=scheduler, memory=memory).table()
    assert set(rows["outcome"]) == {outcome}, rows["detail"][0]
    assert not rows["certified"].any() and rows["detail"][0]
