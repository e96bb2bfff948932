import csv
import errno
import os
import signal
import subprocess
import sys
import textwrap
from dataclasses import fields

import numpy as np
import pytest

from ngcell.errors import OutputError
from ngcell.export import RecordTable
from ngcell.results.record import StepRecord, WallRecord


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_the_columns_are_the_fields_of_the_record(tmp_path):
    RecordTable(tmp_path / "history.csv", StepRecord)
    header = (tmp_path / "history.csv").read_text().splitlines()
    assert header == [",".join(column.name for column in fields(StepRecord))]


def test_floats_come_back_exactly(tmp_path, make_record):
    table = RecordTable(tmp_path / "history.csv", StepRecord)
    table.append(make_record(1, gap=0.1 + 0.2, energy=np.float64(1 / 3), smallest_gap=float("nan")))
    [row] = read(table.path)
    assert float(row["largest_gap"]) == 0.1 + 0.2
    assert row["energy"] == repr(1 / 3)
    assert (row["smallest_gap"], row["step"], row["phase"], row["certified"]) == (
        "nan",
        "1",
        "contact",
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
        RecordTable("/dev/full", StepRecord)
