"""The pictures that a run left, as parts of a page."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from ngcell.report.run_folder import RunFolder

#: Pictures that a run may leave: heading, and the text that stands for each where it is not seen.
_KNOWN = {
    "tissue.png": ("The tissue at the last level", "The deformed tissue at the last level, coloured by X displacement"),
    "gap.png": ("Gaps", "Largest gap, mean gap and number of parted wall pairs over the load"),
    "debonding.png": ("Debonding", "Where and when walls opened, and connected components of cells over the load"),
    "spread.png": ("Spread of the members", "How far the numbers of the members scatter over the load"),
}
_WIDE = "debonding.png"


@dataclass(frozen=True)
class Picture:
    """A picture inside the page."""

    title: str
    described: str
    source: str
    wide: bool = False


def pictures_of(run: RunFolder) -> Iterator[Picture]:
    """Yield the pictures of a run."""
    for name, (title, described) in _KNOWN.items():
        file = run.path / name
        if file.is_file():
            said = described if run.certified else f"{described}; not certified"
            yield Picture(title, said, data_of(file.read_bytes()), wide=name == _WIDE)


@lru_cache(maxsize=32)
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
