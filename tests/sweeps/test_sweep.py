"""Sweeps with workers that only pretend: the table, the store, failures, and how many tasks are on their way."""

from __future__ import annotations

import json
import time
import tomllib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from math import inf
from types import SimpleNamespace

import distributed
import numpy as np
import pandas
import pytest
from click.testing import CliRunner

import ngcell
from ngcell.cli import ngcell as command
from ngcell.errors import CaseError, DependencyError, OutputError
from ngcell.results.observables.observable import check_names
from ngcell.scene import resolved_toml
from ngcell.sweeps import case_run, extra
from ngcell.sweeps.arrays import table_to_xarray
from ngcell.sweeps.driver import connected, finished
from ngcell.sweeps.ending import Ending
from ngcell.sweeps.identity import content_key
from ngcell.sweeps.options import SweepOptions
from ngcell.sweeps.store import Store
from ngcell.sweeps.sweep import Sweep, read_sweep
from ngcell.sweeps.table import PROVENANCE, Table, known_outputs
from ngcell.sweeps.task import OTHER_CODE, Task
from ngcell.sweeps.worker import died
from tests.sweeps.conftest import SMALL, pretend


def run(study, out, scheduler, function=pretend, **options):
    runs = Sweep(study, out, SweepOptions(scheduler=scheduler, function=function, **options))
    for _ in runs:
        pass
    return runs


def test_the_table_is_tidy_and_the_same_in_both_files(study, tmp_path, scheduler):
    table = run(study, tmp_path / "out", scheduler).table()
    assert list(table["case"]) == [number for number in range(6) for _ in range(2)]
    assert list(table["level"]) == [0, 1] * 6 and list(table["load_factor"]) == [0.5, 1.0] * 6
    assert np.allclose(table["energy"], table["tissue.wall"] ** 3 * table["material.c1"] * (table["level"] + 1))
    assert table["parted_pairs"].dtype == int and table["certified"].all()
    assert {"ngcell", "ngsolve", "host", "seconds", "key", "outcome", "energy_error"} <= set(table.columns)
    assert np.isnan(table["mean_gap"]).all()  # the workers pretend to have measured no gap
    as_csv = pandas.read_csv(tmp_path / "out" / "sweep.csv")
    told = ["detail", "failed_checks", "ngcell", "ngsolve"]  # empty, or a text that looks like a number
    pandas.testing.assert_frame_equal(as_csv.drop(columns=told), table.drop(columns=told), check_dtype=False)


def test_the_view_on_the_axes_has_each_number_in_its_place(tmp_path, scheduler):
    file = tmp_path / "study.toml"
    both = "both = { kind = 'zip', values = { material.c1 = [0.5, 1.0], material.c2 = [1.0, 2.0] } }\n"
    file.write_text(f"outputs = ['energy']\n{SMALL}[axes]\ntissue.wall = [0.08, 0.1, 0.12]\n{both}")
    table = run(file, tmp_path / "out", scheduler).table()
    found = ngcell.table_to_xarray(table)
    assert dict(found.sizes) == {"tissue.wall": 3, "both": 2, "level": 2}
    assert list(found["material.c2"].to_numpy()) == [1.0, 2.0] and found["material.c2"].dims == ("both",)
    expected = found["tissue.wall"] ** 3 * found["material.c1"] * (found["level"] + 1)
    assert np.allclose(found["energy"], expected.transpose(*found["energy"].dims))
    part = table_to_xarray(table[table["case"] != 3])
    assert np.isnan(part["energy"][1, 1]).all() and not part["certified"][1, 1].any() and part["outcome"][1, 1, 0] == ""
    with pytest.raises(CaseError, match="does not tell its axes"):
        table_to_xarray(pandas.DataFrame({"case": [0]}))


def test_what_has_been_run_is_not_run_again(study, tmp_path, scheduler):
    first = run(study, tmp_path / "out", scheduler)
    again = run(study, tmp_path / "out", scheduler)
    assert (first.computed, first.reused, again.computed, again.reused) == (6, 0, 0, 6)
    pandas.testing.assert_frame_equal(first.table(), again.table())


def test_a_study_that_grows_computes_what_is_new_and_sweeps_may_share_a_store(study, tmp_path, scheduler):
    store = tmp_path / "store"
    run(study, tmp_path / "one", scheduler, store=store)
    study.write_text(study.read_text().replace("[0.5, 1.0]", "[2.0, 1.0]").replace("[axes]", "[axes]\nmesh.layers=[1]"))
    second = run(study, tmp_path / "two", scheduler, store=store)
    assert second.computed == 6  # another key of the case, which the mesh follows from
    study.write_text(study.read_text().replace("[2.0, 1.0]", "[2.0, 1.0, 4.0]"))
    third = run(study, tmp_path / "three", scheduler, store=store)
    assert (third.computed, third.reused) == (3, 6)
    assert list(third.table()["case"].unique()) == list(range(9))


def takes_a_while(task: Task) -> dict:
    time.sleep(0.05)
    return pretend(task)


def test_sweeps_that_share_a_store_at_the_same_time_share_the_runs(tmp_path, scheduler):
    file, store = tmp_path / "study.toml", tmp_path / "store"
    drawn = "{ kind = 'range', start = 0.05, stop = 0.15, number = 60 }"
    file.write_text(f"outputs = ['energy']\n{SMALL}[axes]\ntissue.wall = {drawn}\n")

    def one(name: str) -> Sweep:
        return run(file, tmp_path / name, scheduler, takes_a_while, store=store)

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(one, ("a", "b"))
    assert all(runs.computed + runs.reused == 60 and runs.certified for runs in (first, second))
    assert first.computed + second.computed < 120  # how many are shared depends on when each looks
    pandas.testing.assert_frame_equal(first.table(), second.table())


def test_points_that_are_one_case_are_run_once(tmp_path, scheduler):
    file = tmp_path / "study.toml"
    file.write_text(f"{SMALL}[axes]\ntissue.wall = [0.1, 0.1, 0.12]\n")
    runs = run(file, tmp_path / "out", scheduler)
    assert runs.computed == 2 and list(runs.table()["case"]) == [0, 0, 1, 1, 2, 2]


def test_a_result_that_is_damaged_is_computed_again(study, tmp_path, scheduler):
    first = run(study, tmp_path / "out", scheduler)
    damaged = next((tmp_path / "out" / "store").rglob("*.json"))
    damaged.write_text(damaged.read_text()[:50])
    again = run(study, tmp_path / "out", scheduler)
    assert again.computed == 1
    pandas.testing.assert_frame_equal(first.table(), again.table())


def test_many_may_write_one_result_at_a_time(tmp_path):
    store, task = Store(tmp_path), Task("ab" * 32, "")
    result = died(task, Ending.KILLED, "x" * 100_000)
    store.write(result)
    assert store.read(task.key) == result and not store.holds(task.key)

    def write_and_read(_):
        store.write({**result, "final": True})
        return store.read(task.key)

    with ThreadPoolExecutor(8) as pool:
        assert all(found == {**result, "final": True} for found in pool.map(write_and_read, range(200)))
    assert store.holds(task.key)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == [f"{task.key}.json"]


def dies_at_first(task: Task) -> dict:
    return died(task, Ending.KILLED, "SIGKILL") if task.attempt == 1 else pretend(task)


def thin_ones_die(task: Task) -> dict:
    return died(task, Ending.OUT_OF_MEMORY, "too large") if "wall = 0.08" in task.text else pretend(task)


def raises(task: Task) -> dict:
    raise RuntimeError("no space left")


def computes_something_else(task: Task) -> dict:
    return died(task, Ending.FAILED, OTHER_CODE)


def test_a_case_whose_process_dies_is_tried_once_more(study, tmp_path, scheduler):
    runs = run(study, tmp_path / "out", scheduler, dies_at_first)
    assert runs.certified and set(runs.table()["attempts"]) == {2}


def test_a_case_that_dies_twice_is_a_row_and_is_tried_by_the_next_sweep(study, tmp_path, scheduler):
    runs = run(study, tmp_path / "out", scheduler, thin_ones_die)
    assert runs.outcomes == Counter({"certified": 4, "out-of-memory": 2}) and not runs.certified
    rows = runs.table()
    dead = rows[rows["tissue.wall"] == 0.08]
    assert list(dead["outcome"]) == ["out-of-memory"] * 2 and list(dead["attempts"]) == [2, 2]
    assert dead["energy"].isna().all() and dead["level"].isna().all() and not dead["certified"].any()
    again = run(study, tmp_path / "out", scheduler)
    assert again.computed == 2 and again.certified


def test_an_error_of_a_worker_is_a_row(study, tmp_path, scheduler):
    rows = run(study, tmp_path / "out", scheduler, raises).table()
    assert set(rows["outcome"]) == {"failed"} and set(rows["detail"]) == {"RuntimeError: no space left"}


def test_a_worker_that_would_compute_something_else_ends_the_sweep(study, tmp_path, scheduler):
    with pytest.raises(OutputError, match="another ngcell, NGSolve or tissue file"):
        run(study, tmp_path / "out", scheduler, computes_something_else)


def test_a_drawn_point_that_makes_no_case_is_a_row(tmp_path, scheduler):
    file = tmp_path / "study.toml"
    drawn = "{ kind = 'random', low = 0.5, high = 1.5, number = 8 }"
    file.write_text(f"outputs = ['energy']\n{SMALL}[axes]\ntissue.wall = {drawn}\n")
    runs = run(file, tmp_path / "out", scheduler)
    assert runs.outcomes["refused"] == len(runs.refused) > 0 and runs.outcomes["certified"] == 8 - len(runs.refused)
    rows = runs.table()
    assert rows[rows["outcome"] == "refused"]["detail"].str.contains("tissue.wall").all()
    assert len(rows) == len(runs.refused) + 2 * (8 - len(runs.refused))


def test_only_so_many_tasks_are_on_their_way_as_keep_the_workers_busy(scheduler):
    taken, ended = 0, 0
    most = 0

    def tasks():
        nonlocal taken, most
        for number in range(200):
            taken += 1
            most = max(most, taken - ended)
            yield Task(f"{number}", _TEXT)

    with connected(scheduler, None) as client:
        for _ in finished(tasks(), client, pretend, 3):
            ended += 1
    assert ended == 200 and most == 5  # one for each of two threads, and three


def test_a_cluster_without_workers_ends_the_sweep_in_one_line(study, tmp_path):
    import distributed

    with distributed.LocalCluster(
        n_workers=0, processes=False, protocol="tcp", host="127.0.0.1", dashboard_address=None
    ) as cluster:
        words = ["sweep", str(study), "--out", str(tmp_path / "out"), "--scheduler", cluster.scheduler_address]
        began = time.monotonic()
        answer = CliRunner().invoke(command, [*words, "--wait", "0.03"])
        assert answer.exit_code == 4 and 1.5 < time.monotonic() - began < 30
    line = answer.stderr.splitlines()[-1]
    assert "no worker for 0.03 minutes" in line and "goes on where it stopped" in line
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["status"] == "stopped"


def test_a_sweep_waits_for_workers_that_join_in_time(study, tmp_path):
    import distributed

    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=False, protocol="tcp", host="127.0.0.1", dashboard_address=None
    ) as cluster, ThreadPoolExecutor(1) as aside:
        aside.submit(lambda: (time.sleep(2.5), cluster.scale(1)))
        assert run(study, tmp_path / "out", cluster.scheduler_address, wait=0.5).computed == 6


@pytest.mark.parametrize("wrong", [{"wait": 0.0}, {"pictures": -1}])
def test_options_out_of_range_are_told(wrong):
    with pytest.raises(CaseError, match="allowed: a"):
        SweepOptions(**wrong)


_TEXT = "tissue.wall = 0.1\nmaterial.c1 = 1.0\nload.levels = 1\n"


def test_the_command_tells_what_it_did_and_what_is_foreseen(study, tmp_path, scheduler, monkeypatch):
    from ngcell.sweeps import options as module

    usual = SweepOptions
    monkeypatch.setattr(module, "SweepOptions", lambda *how, **more: replace(usual(*how, **more), function=pretend))
    monkeypatch.setattr("ngcell.sweeps.driver.available_cores", lambda: 3)  # of a machine that has more
    words = ["sweep", str(study), "--out", str(tmp_path / "out"), "--scheduler", scheduler]
    dry = CliRunner().invoke(command, [*words, "--dry-run"])
    assert dry.exit_code == 0 and "6, of which 6 have to be run" in dry.stdout and not (tmp_path / "out").exists()
    assert "for 3 at a time" in dry.stdout and "on 3 workers here" in dry.stdout
    answer = CliRunner().invoke(command, words)
    assert answer.exit_code == 0, answer.output
    assert "6: 6 certified" in answer.stdout and "6 now, 0 were in the store" in answer.stdout
    assert answer.stderr.splitlines()[-1] == "6 of 6 cases"
    dry = CliRunner().invoke(command, [*words, "--dry-run"])
    assert "6, of which 0 have to be run" in dry.stdout and "from 6 runs of this study" in dry.stdout
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["certified"] and summary["sweep"] == {"cases": 6, "ended": 6, "outcomes": {"certified": 6}}
    assert read_sweep(tmp_path / "out").attrs["axes"][0]["name"] == "tissue.wall"


def test_the_summary_says_what_was_asked_and_the_first_case_in_full(study, tmp_path, scheduler):
    run(study, tmp_path / "out", scheduler)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["study"]["set"]["accuracy"] == "inf"
    first = tomllib.loads(summary["first_case"])
    assert (first["tissue"]["wall"], first["material"]["c1"], first["accuracy"]) == (0.08, 0.5, inf)


def test_the_folder_of_a_run_is_left_as_it_is(study, tmp_path, scheduler):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "summary.json").write_text('{"program": "ngcell", "status": "finished"}')
    with pytest.raises(OutputError, match="holds the result of a run"):
        run(study, tmp_path / "out", scheduler)


def test_no_scheduler_and_no_library_are_one_line(study, tmp_path, monkeypatch):
    client = distributed.Client
    monkeypatch.setattr(distributed, "Client", lambda address, **how: client(address, **{**how, "timeout": "0.5s"}))
    with pytest.raises(OutputError, match="no Dask scheduler answers at tcp://127.0.0.1:1"):
        run(study, tmp_path / "out", "tcp://127.0.0.1:1")

    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(extra, "import_module", missing)
    with pytest.raises(DependencyError, match=r'^sweeps need distributed; .*: pip install "ngcell\[sweep\]"$'):
        Sweep(study, tmp_path / "out")


def test_what_is_foreseen_is_that_of_the_mesh_and_grows_with_it():
    from ngcell.run import inspect
    from ngcell.sweeps.foresee import cost_of

    for settings in (["accuracy=inf"], ["accuracy=inf", "mesh.order=2", "tissue.rows=5"], ["accuracy=0.1"]):
        case = ngcell.read_case("shear-empty-3x3", settings)
        exact = inspect(case)
        unknowns = exact["meshes_foreseen"][-1]["unknowns"]
        assert cost_of(case).unknowns == pytest.approx(unknowns, rel=0.3)
        assert 0.2 * exact["memory_foreseen_gib"] < cost_of(case).memory < 1.1 * exact["memory_foreseen_gib"]
    coarse, fine = (cost_of(ngcell.read_case("press-fit", [f"mesh.size={size}"])) for size in (0.2, 0.1))
    assert fine.unknowns == pytest.approx(4 * coarse.unknowns, rel=0.2)


def test_the_time_that_is_left_follows_the_clock():
    from ngcell.sweeps.pace import Pace

    pace = Pace(100.0)
    told = []
    for number in range(1, 51):
        pace.ended(1.0, 3.0 * number)
        told.append(pace.left)
    assert told[0] is None and told[1] is None
    assert told[9].seconds == pytest.approx(270.0) and told[-1].seconds == pytest.approx(150.0)
    assert told[-1].share == 0.1


def test_provenance_that_may_differ_is_told_apart():
    assert set(PROVENANCE) == {"attempts", "seconds", "processor_seconds", "memory_gib", "host"}


def test_a_run_that_was_killed_takes_no_place_of_a_result(tmp_path):
    store, whole, killed = Store(tmp_path), {"key": "ab", "final": True, "n": 1}, {"key": "ab", "final": False, "n": 2}
    store.write(killed)
    assert not store.holds("ab") and store.read("ab") == killed
    store.write(whole)
    store.write(killed)
    assert store.holds("ab") and store.read("ab") == whole
    store.write(whole | {"n": 3})
    assert store.read("ab") == whole | {"n": 3}


def test_a_run_that_has_ended_keeps_its_numbers_where_its_picture_fails(tmp_path, monkeypatch):
    def fails(*_: object, **__: object) -> None:
        raise ImportError("failed to map segment")

    monkeypatch.setattr(case_run, "picture_of", fails)
    small = ["accuracy=inf", "tissue.rows=1", "tissue.cols=2", "mesh.order=1", "load.levels=1", "expected=[]"]
    case = ngcell.read_case("shear-empty-3x3", [*small, "load.displacement=[0.1, 0.0]"])
    task = Task(key=content_key(case), text=resolved_toml(case), picture=True)
    found = case_run.run(task, tmp_path)
    assert found["outcome"] == "certified" and found["final"] and "picture" not in found
    assert found["levels"][0]["step"]["energy"] > 0


@pytest.mark.parametrize("name", ["energy", "case", "outcome"])
def test_an_axis_has_no_name_of_a_column(name, tmp_path):
    file = tmp_path / "study.toml"
    both = "{ kind = 'zip', values = { material.c1 = [0.5, 1.0], material.c2 = [1.0, 2.0] } }"
    file.write_text(f"outputs = ['energy']\n{SMALL}[axes]\n{name} = {both}\n")
    with pytest.raises(CaseError, match=f"axes.{name}: the table has a column of this name; allowed: another name"):
        Sweep(file, tmp_path / "out", SweepOptions(function=pretend))


def test_a_table_has_what_no_whole_number_of_it_can_hold(tmp_path):
    axes = [{"name": "tissue.seed", "values": {"tissue.seed": [1, 2**63]}}]
    table = Table(axes, ["energy", "parted_pairs"])
    step = {"energy": 1.0, "parted_pairs": float("nan"), "certified": True}
    result = {"outcome": "certified", "levels": [{"load_factor": 1.0, "step": step}], "attempts": 1}
    table.write(tmp_path, table.rows(0, {"tissue.seed": 2**63}, result))
    (row,) = ngcell.read_sweep(tmp_path).to_dict("records")
    assert row["tissue.seed"] == str(2**63) and row["energy"] == 1.0 and not row["parted_pairs"] >= 0


def test_walls_with_a_strength_have_their_utilisation_in_the_table(tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(f"outputs = ['energy', 'utilisation']\n{SMALL}[axes]\nmaterial.strength = [0.5, 1.0]\n")
    assert Sweep(file, tmp_path / "out", SweepOptions(function=pretend)).outputs == ("energy", "utilisation")


def test_no_observable_has_the_name_of_a_column_that_every_table_has():
    names = Table([], []).columns.keys()
    for name in names:
        with pytest.raises(CaseError, match="has this name; allowed: a name of its own"):
            check_names([SimpleNamespace(name=name)], known_outputs().keys() | {"certified", "load_factor", "seconds"})
