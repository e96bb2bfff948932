"""Reports in a browser: no error in its console, and sliders, fields, sorting and levels do what they say."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ngcell.report import write_report
from tests.report.results import write_run

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install '.[browser]'")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine")
#: WebGL without a graphics card.
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
WIDTHS = [(1280, 900), (390, 844)]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield opened
        opened.close()


@pytest.fixture(params=WIDTHS, ids=["desk", "telephone"])
def open_page(request: pytest.FixtureRequest, browser: Any) -> Iterator[Any]:
    """Return a function that opens a file; at the end nothing was complained about or loaded from elsewhere."""
    width, height = request.param
    page = browser.new_page(viewport={"width": width, "height": height})
    complaints: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on(
        "request",
        lambda sent: None if sent.url.startswith(("file:", "data:", "blob:")) else complaints.append(sent.url),
    )

    def go(file: Path) -> Any:
        page.goto(file.as_uri())
        page.wait_for_function("[...document.querySelectorAll('.player')].every(one => one.dataset.shown)")
        assert page.evaluate("document.documentElement.scrollWidth") <= width, "nothing makes the page wider"
        return page

    yield go
    page.close()
    assert complaints == []


def stage(page: Any, number: int = 0) -> bytes:
    page.wait_for_timeout(150)
    picture: bytes = page.locator("[data-part=stage]").nth(number).screenshot()
    return picture


def told(page: Any, number: int = 0) -> str:
    return str(page.locator("[data-part=told]").nth(number).inner_text())


@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_the_slider_moves_the_picture_and_says_where_it_is(open_page: Any, tmp_path: Path, solid: bool) -> None:
    page = open_page(write_report([write_run(tmp_path / "run", solid=solid)]).file)
    last = stage(page)
    assert told(page).startswith("level 3 of 3: plate displacement 0.3")
    slider = page.locator("[data-part=level]")
    slider.focus()
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("document.querySelector('.player').dataset.shown.startsWith('1 ')")
    assert told(page).startswith("level 2 of 3") and slider.get_attribute("aria-valuetext") == told(page)
    middle = stage(page)
    assert middle != last
    page.locator("[data-part=on]").click()
    page.wait_for_function("document.querySelector('.player').dataset.shown.startsWith('2 ')")
    assert stage(page) == last
    page.select_option("[data-part=field]", label="gap")
    page.wait_for_function("document.querySelector('.player').dataset.shown.endsWith('gap')")
    assert stage(page) != last
    assert "gap; from 0.1 to 0.3" in page.locator("[data-part=whole]").inner_text()


def test_a_solid_is_rotated_by_dragging_and_by_keys(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run", solid=True)]).file)
    first = stage(page)
    page.locator("[data-part=stage]").focus()
    page.keyboard.press("ArrowRight")
    second = stage(page)
    box = page.locator("[data-part=stage]").bounding_box()
    page.mouse.move(box["x"] + 60, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(box["x"] + 160, box["y"] + 90)
    page.mouse.up()
    assert len({first, second, stage(page)}) == 3
    page.locator("[data-part=reset]").click()
    page.mouse.move(0, 0)
    page.locator("[data-part=stage]").focus()
    assert told(page).startswith("level 3 of 3")


def test_the_picture_shows_the_bodies_and_not_an_empty_stage(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run")]).file)
    count = page.evaluate(
        """() => {
          const canvas = document.querySelector('[data-part=bodies]'), copy = document.createElement('canvas');
          Object.assign(copy, { width: canvas.width, height: canvas.height });
          const brush = copy.getContext('2d');
          brush.drawImage(canvas, 0, 0);
          const data = brush.getImageData(0, 0, copy.width, copy.height).data;
          const found = new Set();
          let drawn = 0;
          for (let i = 0; i < data.length; i += 4) if (data[i + 3]) {
            drawn++;
            found.add(data[i] + ',' + data[i + 1] + ',' + data[i + 2]);
          }
          return { share: drawn / (data.length / 4), colours: found.size };
        }"""
    )
    # Two rings of 1 - 0.8^2 each, in a window of 2.3 by 1 and its margins.
    assert 0.15 < count["share"] < 0.45 and count["colours"] > 20


def test_a_rigid_body_is_filled_and_carries_no_field(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run", rigid=True)]).file)
    grey = """name => {
      const canvas = document.querySelector(`[data-part=${name}]`), copy = document.createElement('canvas');
      Object.assign(copy, { width: canvas.width, height: canvas.height });
      const brush = copy.getContext('2d');
      brush.drawImage(canvas, 0, 0);
      const data = brush.getImageData(0, 0, copy.width, copy.height).data;
      let rigid = 0, right = 0;
      for (let i = 0; i < data.length; i += 4) {
        rigid += data[i + 3] && data[i] === 0xaa && data[i + 1] === 0xb0 && data[i + 2] === 0xb8;
        right += data[i + 3] && (i / 4) % copy.width > 0.6 * copy.width;
      }
      return [rigid / (data.length / 4), right / (data.length / 4)];
    }"""
    filled, _ = page.evaluate(grey, "under")
    assert 0.25 < filled < 0.6, "a whole unit square in a window of 2.3 by 1 and its margins"
    assert page.evaluate(grey, "bodies")[1] == 0, "no element of it is coloured"
    _, words = page.evaluate(grey, "over")
    assert words > 0
    assert "from 0 to 2.333" in page.locator("[data-part=whole]").inner_text(), "the field is that of the first ring"


def test_a_cell_that_nothing_holds_is_hatched(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run")]).file)
    shades = page.evaluate(
        """() => {
          const canvas = document.querySelector('[data-part=under]'), found = [new Set(), new Set()];
          const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
          for (let i = 0; i < data.length; i += 4)
            if (data[i + 3] === 255) found[Number((i / 4) % canvas.width > canvas.width / 2)].add(data[i]);
          return found.map(one => Math.max(...one) - Math.min(...one));
        }"""
    )
    assert shades[0] < 10 < 40 < shades[1], "in grey, too: the second ring, on the right, is free"


def test_rows_are_sorted_by_their_numbers_and_filtered_by_their_levels(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run")]).file)
    table = page.locator("#run-0-wall-rows")
    place = 1 + table.locator("th").all_inner_texts().index("largest gap")
    head = table.locator(f"th:nth-child({place})")

    def gaps() -> list[str]:
        return [text for text in table.locator(f"tbody tr:visible td:nth-child({place})").all_inner_texts() if text]

    assert gaps() == ["2", "10", "0.5"], "the rows of the last level"
    head.locator("button").click()
    assert gaps() == ["0.5", "2", "10"] and head.get_attribute("aria-sort") == "ascending"
    head.locator("button").focus()
    page.keyboard.press("Enter")
    assert gaps() == ["10", "2", "0.5"] and head.get_attribute("aria-sort") == "descending"
    page.locator("select[data-table=run-0-wall-rows]").select_option("")
    assert len(gaps()) == 9


def test_a_level_that_is_not_certified_is_stamped(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run", certified=False)]).file)
    stamp = page.locator("[data-part=stamp]")
    assert stamp.inner_text() == "NOT CERTIFIED" and "NOT CERTIFIED" in told(page)
    page.locator("[data-part=back]").click()
    page.wait_for_function("document.querySelector('.player').dataset.shown.startsWith('1 ')")
    assert stamp.inner_text() == "RUN NOT CERTIFIED"


def test_a_run_that_is_certified_has_no_stamp(open_page: Any, tmp_path: Path) -> None:
    page = open_page(write_report([write_run(tmp_path / "run")]).file)
    assert not page.locator("[data-part=stamp]").is_visible()


def test_levels_of_runs_side_by_side_change_together_until_told_otherwise(open_page: Any, tmp_path: Path) -> None:
    folders = [write_run(tmp_path / "one"), write_run(tmp_path / "two", levels=2)]
    page = open_page(write_report(folders, tmp_path / "page.html").file)
    page.locator("[data-part=level]").first.fill("0")
    page.wait_for_function("[...document.querySelectorAll('.player')].every(one => one.dataset.shown.startsWith('0 '))")
    assert told(page, 1).startswith("level 1 of 2")
    page.uncheck("#together")
    page.locator("[data-part=level]").first.fill("1")
    page.wait_for_function("document.querySelector('.player').dataset.shown.startsWith('1 ')")
    assert told(page, 1).startswith("level 1 of 2")


def test_a_browser_that_draws_no_webgl_says_so(browser: Any, tmp_path: Path) -> None:
    page = browser.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(write_report([write_run(tmp_path / "run")]).file.as_uri())
    assert "no WebGL 2" in page.locator("[data-part=reading]").inner_text()
    page.close()
