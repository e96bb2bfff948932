"""The site builds without a warning; its gallery and its notebooks run, at small size; what it lists is complete."""

from __future__ import annotations

import contextlib
import io
import re
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

import ngcell
from ngcell.scene import schema
from tools.docs import commands, extra, gallery, notebooks, reference
from tools.docs.case_reference import case_reference
from tools.docs.site import prepare, sphinx
from tools.docs.sources import as_source
from tools.places import DOCS, ROOT

#: Small settings of the notebooks, by their names.
SMALL = {"pressure-delays-the-gap": 'ACCURACY, PRESSURES, LEVELS = "inf", [0.0, 0.005], [0.4]'}


#: What scripts of the gallery ask for, and what takes less time: coarse meshes, no estimate of errors, one level.
CHEAPER = {
    r"accuracy=0\.1\)": 'accuracy=float("inf"), mesh=ngcell.MeshChoice(order=2))',
    r'"accuracy=0\.1"': '"accuracy=inf", "mesh.order=2"',
    r"levels=\d": "levels=1",
    r'"tissue.cols=2", "mesh.order=2"': '"tissue.cols=1", "mesh.order=1"',
    r"\[1\.0, 0\.0\]": "[0.2, 0.0]",
    r'"shear-empty-3x3", \["accuracy': '"shear-empty-3x3", ["tissue.rows=2", "tissue.cols=2", "accuracy',
}


def smaller(text: str) -> str:
    """Return a script that takes less time."""
    for asked, cheaper in CHEAPER.items():
        text = re.sub(asked, cheaper, text)
    return text


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the site, built with warnings as errors; its gallery is not run."""
    folder = tmp_path_factory.mktemp("site")
    prepare(folder / "source", pictures=folder / "gallery", run_gallery=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of Sphinx, for those who write extensions
        assert sphinx(folder / "source", folder / "site", folder / "doctrees") == 0
    return folder / "site"


def test_the_site_has_all_pages_and_takes_nothing_from_the_network(site: Path) -> None:
    pages = {str(path.relative_to(DOCS).with_suffix(".html")) for path in DOCS.rglob("*.md")}
    made = {"reference/case.html", "reference/commands.html", "reference/python.html", "gallery/index.html"}
    made |= {f"notebooks/{file.stem}.html" for file in notebooks.NOTEBOOKS}
    built = {str(path.relative_to(site)): path.read_text() for path in site.rglob("*.html")}
    assert built.keys() >= pages | made | {"changelog.html", "contributing.html"}
    assert not [name for name, text in built.items() if re.search(r'(src|href)="(https?:)?//[^"]*\.(js|css)', text)]


def test_equations_are_drawn_by_the_browser(site: Path) -> None:
    theory = (site / "theory.html").read_text()
    assert theory.count("<math") > 20 and "MathJax" not in theory
    assert "merror" not in theory


def test_the_commands_and_the_public_names_are_in_the_site(site: Path) -> None:
    commands, names = ((site / "reference" / f"{page}.html").read_text() for page in ("commands", "python"))
    assert all(f'id="ngcell-{verb}"' in commands for verb in ("solve", "check", "view", "cases", "schema"))
    assert all(f'id="ngcell.{name}"' in names for name in ngcell.__all__)
    assert sorted(name for _, listed in reference.sections() for name in listed) == sorted(ngcell.__all__)


def test_the_case_reference_explains_every_entry() -> None:
    tables = schema()["$defs"]
    page = case_reference()
    unexplained = [
        f"{name}.{entry}"
        for name, table in tables.items()
        for entry, what in table["properties"].items()
        if entry != "kind" and not what.get("description")
    ]
    assert unexplained == []
    assert all(f"## {name}" in page for name in tables)


def test_links_follow_their_targets_into_the_site() -> None:
    assert "](tables/accuracy.md)" in as_source(DOCS / "accuracy.md")
    assert "](../contributing.md#how-to-add-a-kind)" in as_source(DOCS / "how-to" / "own-contact.md")
    assert "](docs/" not in as_source(ROOT / "CONTRIBUTING.md")


@pytest.mark.parametrize("script", gallery.SCRIPTS, ids=lambda path: path.stem)
def test_a_script_of_the_gallery_prints_its_numbers_and_draws(script: Path, tmp_path: Path) -> None:
    title, text, code = gallery.parts(script)
    assert title and text and len(code.splitlines()) <= 45
    with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.chdir(tmp_path):
        exec(smaller(script.read_text()), {})
    numbers, _, picture = printed.getvalue().rpartition(gallery.SHOWN)
    assert re.search(r"\d", numbers) and "certified: " in numbers
    assert (tmp_path / picture.strip()).stat().st_size > 1000


def test_results_of_the_gallery_are_kept_until_the_script_changes(tmp_path: Path) -> None:
    script = tmp_path / "a.py"
    script.write_text('"""A\n\nb\n"""\nopen("p.png", "w").close()\nprint(1)\nprint("picture: p.png")\n')
    first = gallery.result(script, tmp_path / "kept")
    assert first.printed == "1" and gallery.result(script, tmp_path / "kept") == first
    script.write_text(script.read_text().replace("print(1)", "print(2)"))
    assert gallery.result(script, tmp_path / "kept").printed == "2"


def test_a_script_that_fails_stops_the_build(tmp_path: Path) -> None:
    script = tmp_path / "a.py"
    script.write_text('"""A"""\nraise SystemExit("nothing")\n')
    with pytest.raises(RuntimeError, match="nothing"):
        gallery.run(script, tmp_path / "picture.png")


@pytest.mark.parametrize("file", notebooks.NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_holds_no_path_of_a_machine(file: Path) -> None:
    kept = notebooks.read(file)
    assert notebooks.foreign(kept) == []
    assert all(cell.outputs for cell in kept.cells[2:] if cell.cell_type == "code")
    ran = notebooks.executed(notebooks.read(file), SMALL[file.stem])
    assert any("image/png" in output.get("data", {}) for cell in ran.cells for output in cell.get("outputs", ()))


def test_a_path_of_a_machine_is_found() -> None:
    assert notebooks.foreign({"text": "in /home/me/x.py"}) == ["/home/me/x.py"]


@pytest.mark.parametrize(("name", "module"), [("site", "furo"), ("notebooks", "nbclient"), ("release", "hatchling")])
def test_a_missing_extra_is_told_in_a_line(name: str, module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    known = find_spec
    monkeypatch.setattr(extra, "find_spec", lambda asked: None if asked == module else known(asked))
    answer = CliRunner().invoke(commands, [name])
    assert answer.exit_code == 1
    assert re.fullmatch(rf'Error: {module} missing: pip install "\.\[\w+\]"\n', answer.output)
