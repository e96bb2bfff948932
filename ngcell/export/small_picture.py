"""A small picture of the tissue of a run, for pages that show many runs."""

from __future__ import annotations

import io
from pathlib import Path
from tempfile import TemporaryDirectory

from ngcell.errors import OutputError
from ngcell.export.picture import draw_tissue
from ngcell.export.series import read_last_snapshot

#: Width [pixels], and number of colours.
_WIDTH, _COLOURS = 640, 96


def small_tissue(run: Path, *, certified: bool) -> bytes | None:
    """Return a small picture (PNG) of the last level that a run has reached; None where none can be drawn."""
    from PIL import Image

    with TemporaryDirectory(prefix="ngcell-picture-") as folder:
        try:
            snapshot, _ = read_last_snapshot(run)
            large = draw_tissue(snapshot, Path(folder) / "tissue.png", title="", certified=certified)
        except OutputError:  # no level was accepted, or the bodies are not in the plane
            return None
        with Image.open(large) as image:
            size = _WIDTH, round(_WIDTH * image.height / image.width)
            small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS).quantize(_COLOURS)
    content = io.BytesIO()
    small.save(content, "PNG", optimize=True)
    return content.getvalue()
