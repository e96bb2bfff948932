"""The pictures that a run left, as parts of a page."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from ngcell.report.run_folder import RunFolder
from ngcell.report.sources import Rows, Source, run_is_certified

#: Pictures that a run may leave: heading, and the text that stands for each where it is not seen.
_KNOWN = {
    "tissue.png": ("The tissue at the last level", "The deformed tissue at the last level, coloured by X displacement"),
    "gap.png": ("Gaps", "Largest gap, mean gap and number of parted wall pairs over the load"),
    "debonding.png": ("Debonding", "Where and when walls opened, and connected components of cells over the load"),
    "spread.png": ("Spread of the members", "How far the numbers of the members scatter over the load"),
}
_WIDE = "debonding.png"
#: Where the folder of a sweep has the picture of a case, and the bytes that pictures of cases may have on a page.
_OF_CASE, _BYTES = "pictures/case_{:06d}.png", 4_000_000


@dataclass(frozen=True)
class Picture:
    """A picture inside the page."""

    title: str
    described: str
    source: str
    wide: bool = False
    refused: bool = False


def pictures_of(run: RunFolder) -> Iterator[Picture]:
    """Yield the pictures of a run."""
    for name, (title, described) in _KNOWN.items():
        file = run.path / name
        if file.is_file():
            said = described if run.certified else f"{described}; not certified"
            yield Picture(title, said, data_of(file.read_bytes()), wide=name == _WIDE)


def pictures_of_cases(source: Source, last: Rows, axes: Sequence[str]) -> Iterator[Picture]:
    """Yield the pictures of cases of a sweep that its folder has, up to a number of bytes."""
    left = _BYTES
    for row in last:
        file = source.path / _OF_CASE.format(int(row["case"])) if row.get("case", "").isdigit() else None
        if file is None or not file.is_file():
            continue
        data, certified = data_of(file.read_bytes()), run_is_certified(row)
        left -= len(data)
        if left < 0:
            return
        values = ", ".join(f"{axis.rpartition('.')[2]} {row[axis]}" for axis in axes)
        title = f"case {row['case']}" + (f": {values}" if values else "")
        described = f"The deformed tissue of {title}" + ("" if certified else f"; not certified, {row.get('outcome')}")
        yield Picture(title, described, data, refused=not certified)


@lru_cache(maxsize=64)
def data_of(png: bytes) -> str:
    """Return a picture as a page holds it: without loss as WebP, which takes half the bytes, where Pillow can."""
    from PIL import Image, UnidentifiedImageError, features

    kind, content = "png", png
    if features.check("webp"):
        smaller = io.BytesIO()
        try:
            Image.open(io.BytesIO(png)).convert("RGB").save(smaller, "WEBP", lossless=True, quality=60)
            kind, content = "webp", smaller.getvalue()
        except (UnidentifiedImageError, OSError):
            pass  # a browser tells what it cannot show
    return f"data:image/{kind};base64,{b64encode(content).decode()}"
