import csv
import errno
import os
import signal
import subprocess
import sys
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np
import pytest

from ngcell.errors import OutputError
from ngcell.export import RecordTable
from ngcell.results.record import StepRecord, WallRecord


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


@dataclass(frozen=True)
class Observed:
    """A record with further columns."""

    step: int
    energy: float
    more: Mapping[str, float] = field(default_factory=dict)


def test_the_columns_are_the_fields_of_the_record(tmp_path):
    RecordTable(tmp_path / "walls.csv", WallRecord)
    header = (tmp_path / "walls.csv").read_text().splitlines()
    assert header == [",".join(column.name for column in fields(WallRecord))]


def test_floats_come_back_exactly(tmp_path, make_record):
    table = RecordTable(tmp_path / "history.csv", StepRecord)
    table.append(make_record(1, gap=0.1 + 0.2, energy=np.float64(1 / 3), smallest_gap=float("nan")))
    [row] = read(table.path)
    assert float(row["largest_gap"]) == 0.1 + 0.2
    assert row["energy"] == repr(1 / 3)
    assert (row["smallest_gap"], row["step"], row["phase"], row["certified"]) == (
        "nan",
        "1",
        "released",
        "True",
    )


def test_rows_are_readable_before_the_table_is_closed(tmp_path, wall_records):
    table = RecordTable(tmp_path / "walls.csv", WallRecord)
    table.append(*wall_records(1), *wall_records(2))
    assert [row["step"] for row in read(table.path)] == ["1", "2"]


def test_a_killed_run_leaves_whole_rows(tmp_path):
    program = textwrap.dedent("""
        import os, signal, sys
        from pathlib import Path
        from ngcell.export import RecordTable
        from ngcell.results.record import WallRecord
        table = RecordTable(Path(sys.argv[1]), WallRecord)
        for step in range(3):
            table.append(WallRecord(step, 0.5, 0, 1, 0.1, 0.05, 0.0, 1.0, True, 0, 0.2))
        os.kill(os.getpid(), signal.SIGKILL)
    """)
    killed = subprocess.run([sys.executable, "-c", program, tmp_path / "walls.csv"], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert [row["component"] for row in read(tmp_path / "walls.csv")] == ["0", "0", "0"]


def test_a_row_that_the_disk_refuses_is_taken_back(tmp_path, make_record, monkeypatch):
    table = RecordTable(tmp_path / "history.csv", StepRecord)
    table.append(make_record(1))
    before = table.path.read_bytes()

    def refuse(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OutputError, match=r"history\.csv: No space left on device; free some space"):
        table.append(make_record(2))
    assert table.path.read_bytes() == before
    monkeypatch.undo()
    table.append(make_record(3))
    assert [row["step"] for row in read(table.path)] == ["1", "3"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs the device that is always full")
def test_a_full_disk_is_one_clear_line():
    with pytest.raises(OutputError, match="cannot write /dev/full: No space left on device"):
        RecordTable("/dev/full", WallRecord)


def test_the_first_record_fixes_the_further_columns(tmp_path):
    table = RecordTable(tmp_path / "history.csv", Observed)
    assert table.path.read_text() == ""
    table.append(Observed(0, 1.5, {"drift": 1 / 3, "count, all": 2}))
    table.append(Observed(1, 2.5, {"count, all": 3, "drift": np.float64(0.1)}))
    assert table.path.read_text() == f'step,energy,drift,"count, all"\n0,1.5,{1 / 3!r},2\n1,2.5,0.1,3\n'
    for more in ({}, {"drift": 0.0}, {"drift": 0.0, "count, all": 1, "other": 2.0}):
        before = table.path.read_bytes()
        with pytest.raises(OutputError, match="the first row fixes them"):
            table.append(Observed(2, 3.5, more))
        assert table.path.read_bytes() == before


def test_further_columns_that_are_named_stand_in_the_header_at_once(tmp_path):
    table = RecordTable(tmp_path / "history.csv", Observed, more=["drift"])
    assert table.path.read_text() == "step,energy,drift\n"
    RecordTable(tmp_path / "plain.csv", Observed, more=()).append(Observed(0, 1.0))
    assert (tmp_path / "plain.csv").read_text() == "step,energy\n0,1.0\n"


@pytest.mark.parametrize("more", [None, ["energy"]])
def test_a_further_column_cannot_have_the_name_of_another(tmp_path, more):
    with pytest.raises(OutputError, match="has a column 'energy' already"):
        RecordTable(tmp_path / "history.csv", Observed, more=more).append(Observed(0, 1.0, {"energy": 2.0}))


def test_a_first_row_that_is_taken_back_takes_its_header_along(tmp_path, monkeypatch):
    table = RecordTable(tmp_path / "history.csv", Observed)

    def refuse(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OutputError, match="No space left"):
        table.append(Observed(0, 1.0, {"drift": 0.5}))
    monkeypatch.undo()
    assert (table.path.read_bytes(), table.size) == (b"", 0)
    table.append(Observed(0, 1.0, {"drift": 0.5}))
    table.rewind(0)
    table.append(Observed(1, 2.0, {"other": 0.25}))
    assert table.path.read_text() == "step,energy,other\n1,2.0,0.25\n"


def test_a_table_goes_on_with_the_columns_that_it_had(tmp_path):
    path = tmp_path / "history.csv"
    table = RecordTable(path, Observed)
    table.append(Observed(0, 1.0, {"b": 0.5, "a": 0.25}))
    size = table.size
    table.append(Observed(1, 1.0, {"b": 0.5, "a": 0.25}))
    table.close()
    resumed = RecordTable(path, Observed, size=size)
    resumed.append(Observed(1, 2.0, {"a": 0.75, "b": 1.0}))
    assert path.read_text() == "step,energy,b,a\n0,1.0,0.5,0.25\n1,2.0,1.0,0.75\n"
    with pytest.raises(OutputError, match="the first row fixes them"):
        resumed.append(Observed(2, 2.0, {"a": 0.75}))


def test_a_table_without_a_row_yet_goes_on_with_those_of_its_first(tmp_path):
    path = tmp_path / "history.csv"
    RecordTable(path, Observed).close()
    RecordTable(path, Observed, size=0).append(Observed(0, 1.0, {"a": 0.5}))
    assert path.read_text() == "step,energy,a\n0,1.0,0.5\n"


@pytest.mark.parametrize(("size", "more"), [(1000, None), (20, None), (0, ["drift"]), (None, []), (None, ["other"])])
def test_a_table_that_is_not_what_it_was_is_refused(tmp_path, size, more):
    path = tmp_path / "history.csv"
    RecordTable(path, Observed).append(Observed(0, 1.0, {"drift": 0.5}))
    whole = path.read_bytes()
    with pytest.raises(OutputError, match="is not the table that it was"):
        RecordTable(path, Observed, size=len(whole) if size is None else size, more=more)
    assert path.read_bytes() == whole


def test_a_table_of_other_columns_is_refused(tmp_path, make_record):
    table = RecordTable(tmp_path / "history.csv", StepRecord)
    table.append(make_record(1))
    for record_type in (WallRecord, Observed):
        with pytest.raises(OutputError, match="is not the table that it was"):
            RecordTable(table.path, record_type, size=table.size)
