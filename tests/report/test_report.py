"""The report: what it tells of a run, of several, of members and of sweeps, and of folders that lack something."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from math import nan
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from ngcell.cli import ngcell
from ngcell.errors import OutputError
from ngcell.export import write_summary
from ngcell.report import page as page_module
from ngcell.report import pictures as pictures_module
from ngcell.report import write_report
from ngcell.report.charts import figures_of
from ngcell.report.player import player_of
from ngcell.report.rows import levels_table
from ngcell.report.sources import read_source
from tests.report.results import record, snapshot, write_run


class Words(HTMLParser):
    """Reads the words of a page, without scripts and styles, and notes tags that are not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.words: list[str] = []
        self.open: list[str] = []
        self.ids: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        told = dict(attrs)
        self.ids += [told["id"] or ""] if "id" in told else []
        self.loads += [told[key] or "" for key in ("src", "href", "xlink:href") if key in told]
        if tag not in {"meta", "link", "input", "img", "br"}:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.words.append(data)


def read(file: Path) -> SimpleNamespace:
    text = file.read_text(encoding="utf-8")
    parser = Words()
    parser.feed(text)
    parser.close()
    assert parser.open == []
    return SimpleNamespace(
        text=text, words=" ".join(" ".join(parser.words).split()), ids=parser.ids, loads=parser.loads
    )


def test_a_page_says_first_whether_a_run_is_certified_and_tells_all_of_it(tmp_path: Path) -> None:
    report = write_report([write_run(tmp_path / "run")])
    assert report.file == tmp_path / "run" / "report.html" and report.remarks == ()
    page = read(report.file)
    order = ["Two rings <come apart>", "Certified", "Converged; 2 checks passed", "energy", "0.09", "± 10 %",
             "1 of 1 wall pair opened", "The deformed tissue", "Over the load", "Pictures of the run",
             "What was asked", "kind honeycomb", "Certificate", "forces out of balance", "Walls", "Cells",
             "case.toml", "versions", "ngcell 9.9.9"]  # fmt: skip
    places = [page.words.index(words) for words in order[:4]] + [page.words.find(words) for words in order[4:]]
    assert -1 not in places and places[:4] == sorted(places[:4])
    assert "not certified" not in page.words.replace("a level that is not certified", "").lower()
    assert 'name="viewport"' in page.text and page.text.count("<svg") == 5


def test_a_page_loads_nothing_and_names_each_part_once(tmp_path: Path) -> None:
    page = read(write_report([write_run(tmp_path / "run")]).file)
    assert all(re.match(r"#|data:", load) for load in page.loads)
    assert "http://" not in re.sub(r'xmlns(:\w+)?="[^"]*"|<!DOCTYPE[^>]*>', "", page.text)
    assert len(page.ids) == len(set(page.ids))


def test_every_figure_of_a_run_that_is_not_certified_says_so(tmp_path: Path) -> None:
    page = read(write_report([write_run(tmp_path / "run", certified=False)]).file)
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", page.text, re.DOTALL)
    assert len(captions) >= 7 and all("not certified" in caption for caption in captions)
    assert page.text.count(">not certified</text>") + page.text.count("not certified</text>") >= 5
    assert "residual is 0.5, its limit 1e-06" in page.words and "To try: refine the mesh" in page.words
    assert "NOT PASSED" in page.words and "NOT CERTIFIED: Two rings" in page.text
    data = player_of([(snapshot(0), True), (snapshot(1), False)], 10**7).data
    assert [level["certified"] for level in data["levels"]] == [True, False]


def test_a_run_that_was_stopped_is_told_as_far_as_it_got(tmp_path: Path) -> None:
    page = read(write_report([write_run(tmp_path / "run", ends=False)]).file)
    assert "Not certified" in page.words and "The run was stopped (not finished) after 3 accepted steps." in page.words
    assert "Two rings" in page.words and "0.09" in page.words


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("history.csv", "history.csv is missing or empty"),
        ("case.toml", "case.toml cannot be read"),
        ("tissue.pvd", "tissue.pvd is missing"),
        ("tissue_0001.vtu", "cannot read snapshot 1"),
        ("walls.csv", "walls.csv is missing or empty"),
    ],
)
def test_what_a_folder_lacks_is_one_line_and_the_rest_is_told(tmp_path: Path, name: str, told: str) -> None:
    folder = write_run(tmp_path / "run")
    (folder / name).unlink()
    answer = CliRunner().invoke(ngcell, ["report", str(folder)])
    assert answer.exit_code == 0
    (line,) = answer.stderr.splitlines()
    assert told in line
    assert told in read(folder / "report.html").words


def test_tables_that_are_damaged_are_told(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run")
    (folder / "cells.csv").write_text("nonsense\n1\n")
    assert any("cells.csv is not the table" in line for line in write_report([folder]).remarks)


def test_further_columns_are_told_and_drawn() -> None:
    history = [replace(record(step), more={"twist_of_cell": 0.5 * step}) for step in range(3)]
    (table,) = levels_table("run", history)
    assert [column.title for column in table.columns][-1] == "twist of cell" and table.rows[2].cells[-1].text == "1"
    figures = figures_of({"run": history}, {"run": True}, key="run")
    assert figures[-1].title == "twist of cell" and "0 to 1 over" in figures[-1].described


def test_a_history_without_a_number_is_drawn_without_it() -> None:
    history = [replace(record(step), energy=nan) for step in range(2)]
    assert "Energy" not in [figure.title for figure in figures_of({"run": history}, {"run": True}, key="run")]


def test_what_is_no_result_is_one_line_and_exit_4(tmp_path: Path) -> None:
    answer = CliRunner().invoke(ngcell, ["report", str(tmp_path)])
    assert answer.exit_code == 4 and len(answer.stderr.splitlines()) == 1
    assert CliRunner().invoke(ngcell, ["report", str(tmp_path / "nothing")]).exit_code == 2
    assert CliRunner().invoke(ngcell, ["report", str(tmp_path), "--out", "a.png"]).exit_code == 2


def test_one_folder_that_cannot_be_read_does_not_hide_the_others(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run")
    (tmp_path / "empty").mkdir()
    report = write_report([run, tmp_path / "empty"], tmp_path / "page.html")
    page = read(report.file)
    assert "Not everything could be read" in page.words and "empty holds neither" in page.words
    assert page.text.count("NOT CERTIFIED: ") == 1, "the page as a whole is not"


def test_runs_are_told_side_by_side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one, two = write_run(tmp_path / "one"), write_run(tmp_path / "two", levels=2, certified=False)
    monkeypatch.chdir(tmp_path)
    report = write_report([one, two])
    assert report.file == Path("report.html")
    page = read(report.file)
    assert "1 of 2 results are certified" in page.words and "Deformed, side by side" in page.words
    assert "one</text>" in page.text and "two, not certified</text>" in page.text
    assert "What the cases say differently" in page.words and "levels 3" in page.words and "levels 2" in page.words
    assert len(page.ids) == len(set(page.ids))


def test_runs_whose_folders_have_one_name_are_told_apart(tmp_path: Path) -> None:
    folders = [write_run(tmp_path / part / "run") for part in "ab"]
    words = read(write_report(folders, tmp_path / "page.html").file).words
    assert "a/run" in words and "b/run" in words


def test_members_are_told_with_their_spread(tmp_path: Path) -> None:
    for number in range(2):
        write_run(tmp_path / "all" / f"member_{number:03d}", certified=number == 0)
    rows = ["level,load_factor,number,members,mean,deviation,smallest,largest,error,known_to,remark",
            "0,1.0,energy,1,0.25,nan,0.25,0.25,0.01,nan,of one"]  # fmt: skip
    (tmp_path / "all" / "spread.csv").write_text("\n".join(rows) + "\n")
    about = {"program": "ngcell", "status": "finished", "title": "Rings", "certified": False, "members": {"count": 3}}
    write_summary(tmp_path / "all", about)
    words = read(write_report([tmp_path / "all"]).file).words
    assert "1 of 3 members are certified" in words and "member_001: not certified" in words
    assert "0.25" in words and "of one" in words


SWEEP = """case,tissue.wall,level,load_factor,energy,certified,outcome,host
0,0.1,0,0.5,0.2,True,certified,here
0,0.1,1,1.0,0.3,True,certified,here
1,0.2,0,0.5,0.4,True,failed,here
1,0.2,1,1.0,,False,failed,here
2,0.3,0,1.0,0.9,True,certified,here
"""


def test_a_sweep_is_told_by_its_table(tmp_path: Path) -> None:
    (tmp_path / "sweep.csv").write_text(SWEEP)
    about = {"program": "ngcell", "status": "finished", "title": "Walls", "sweep": {"cases": 4}, "certified": False}
    write_summary(tmp_path, about | {"study": {"case": "shear-empty"}})
    page = read(write_report([tmp_path]).file)
    assert "3 of 4 cases have ended: 2 certified, 1 failed." in page.words
    assert "1 of 5 rows of the table are not certified." in page.words
    assert "energy over tissue.wall" in page.words and "shear-empty" in page.words
    assert page.text.count('class="refused"') == 1 and "here" not in page.words.split()


def test_a_sweep_tells_its_errors_its_first_case_and_its_versions(tmp_path: Path) -> None:
    rows = ["case,tissue.wall,level,load_factor,energy,energy_error,dark,certified,outcome,processor_seconds,ngcell"]
    rows += [f"{n},0.{n + 1},0,1.0,0.{n + 2},0.01,3,True,certified,2.0,9.9.9" for n in range(3)]
    (tmp_path / "sweep.csv").write_text("\n".join(rows) + "\n")
    about = {"program": "ngcell", "status": "finished", "title": "Walls", "first_case": "[tissue]\nwall = 0.1"}
    write_summary(tmp_path, about | {"study": {"case": "shear-empty", "set": {"accuracy": "inf"}}})
    page = read(write_report([tmp_path]).file)
    for words in ("Bars are estimated errors.", "fully resolved [tissue] wall = 0.1", "6 s of the processor for 3 runs",
                  "ngcell 9.9.9", "accuracy inf", "dark over tissue.wall"):  # fmt: skip
        assert words in page.words, words
    (tmp_path / "sweep.csv").write_text("\n".join(rows).replace(",0.01,", ",nan,") + "\n")
    bare = read(write_report([tmp_path]).file)
    assert "Errors are not estimated." in bare.words
    assert page.text.count("<path") > bare.text.count("<path"), "bars"


def test_pictures_of_cases_say_which_and_whether_they_are_certified(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sweep.csv").write_text(SWEEP)
    (tmp_path / "pictures").mkdir()
    for number in range(2):
        shutil.copy(write_run(tmp_path / "run") / "tissue.png", tmp_path / "pictures" / f"case_{number:06d}.png")
        shutil.rmtree(tmp_path / "run")
    page = read(write_report([tmp_path]).file)
    assert "Tissues of 2 of 3 cases" in page.words and "case 0: wall 0.1" in page.words
    assert "case 1: wall 0.2 not certified" in page.words and "case 0: wall 0.1 not" not in page.words
    assert "not certified, failed" in page.text
    monkeypatch.setattr(pictures_module, "_BYTES", 10)
    page = read(write_report([tmp_path]).file)
    assert "Tissues of" not in page.words and "case 0: wall" not in page.words


def test_a_sweep_that_has_not_ended_is_not_certified(tmp_path: Path) -> None:
    (tmp_path / "sweep.csv").write_text(SWEEP.replace("False", "True"))
    write_summary(tmp_path, {"program": "ngcell", "status": "stopped", "sweep": {"cases": 3}})
    assert 'class="verdict refused"' in write_report([tmp_path]).file.read_text()


def test_each_level_tells_which_cells_nothing_holds_there() -> None:
    bulk = snapshot(0).bulk
    held = replace(bulk, cell_data={**bulk.cell_data, "free": 0 * bulk.cell_data["free"]})
    data = player_of([(replace(snapshot(0), bulk=held), True), (snapshot(1), True)], 10**7).data
    assert [level["free"] for level in data["levels"]] == [[], [1]]
    assert len(data["shapes"]) == 1, "of one mesh there is one shape"


def test_a_page_stays_small_and_says_what_was_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = player_of([(snapshot(step), True) for step in range(4)], 10**7)
    assert whole.left_out == []
    assert {"von_mises", "gap", "displacement_x", "cauchy_stress_xy"} <= {one["name"] for one in whole.data["fields"]}
    fewer = player_of([(snapshot(step), True) for step in range(4)], whole.size - 1)
    assert fewer.size < whole.size and "fields left out" in fewer.left_out[0]
    least = player_of([(snapshot(step), True) for step in range(4)], 0)
    assert "2 of 4 levels" in least.left_out[-1]
    assert [level["step"] for level in least.data["levels"]] == [1, 3], "the last level stays"
    monkeypatch.setattr(page_module, "_BUDGET", 0)
    assert "fields left out" in read(write_report([write_run(tmp_path / "run")]).file).words


def test_a_new_run_does_not_leave_the_report_of_the_old_one(tmp_path: Path) -> None:
    from ngcell.export.ownership import clear_folder

    file = write_report([write_run(tmp_path / "run")]).file
    clear_folder(tmp_path / "run")
    assert not file.exists()


def test_a_page_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run")
    with pytest.raises(OutputError, match="cannot write"):
        write_report([folder], tmp_path / "no-folder" / "page.html")
    shutil.rmtree(folder)


@pytest.mark.parametrize("outcome", ["certified", "not-as-expected", "not-certified"])
def test_a_sweep_is_certified_if_its_runs_are(tmp_path: Path, outcome: str) -> None:
    """Each level of a run may be certified that is not: another step failed, or a number is not as expected."""
    rows = ["case,tissue.wall,level,load_factor,energy,certified,outcome"]
    rows += [f"{n},0.{n + 1},0,1.0,0.{n + 2},True,{outcome if n == 1 else 'certified'}" for n in range(3)]
    (tmp_path / "sweep.csv").write_text("\n".join(rows) + "\n")
    is_certified = outcome == "certified"
    about = {"program": "ngcell", "status": "finished", "title": "Walls", "sweep": {"cases": 3}}
    write_summary(tmp_path, about | {"certified": is_certified, "study": {"case": "shear-empty"}})
    assert read_source(tmp_path).certified == is_certified
    page = read(write_report([tmp_path]).file)
    assert ("NOT CERTIFIED" in page.words) != is_certified
    assert page.text.count('class="refused"') == (outcome == "not-as-expected")
