"""The last snapshot of a result in a window or, without a display, in a picture."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from ngcell.errors import OutputError
from ngcell.export.picture import draw_tissue
from ngcell.export.series import NOT_CERTIFIED, read_last_snapshot
from ngcell.export.solid_picture import draw_solids, is_of_solids, solid_plot
from ngcell.export.summary import SUMMARY, read_summary
from ngcell.results.snapshot import Snapshot

#: Ending of the names of pictures.
PICTURE = ".png"


def show(folder: Path, screenshot: Path | None = None, clip: float | None = None) -> Path | None:
    """Show the deformed tissue of the last snapshot in `folder`.

    Parameters
    ----------
    folder : Path
        The result of a run, finished or not.
    screenshot : Path, optional
        PNG file to write instead of opening a window. By default there is a window; without a display,
        `tissue.png` in `folder`, for three-dimensional bodies `tissue-3d.png`.
    clip : float, optional
        Share of the height above which three-dimensional bodies are cut off, in (0, 1].

    Returns
    -------
    Path or None
        The picture, or None after a window was closed.

    Raises
    ------
    OutputError
        If the folder holds no snapshot, or the picture cannot be written.
    """
    folder = Path(folder)
    if screenshot is not None and Path(screenshot).suffix.lower() != PICTURE:
        raise OutputError(f"cannot write {screenshot}: allowed: a file {PICTURE}")
    snapshot, certified = read_last_snapshot(folder)
    summary = read_summary(folder) if (folder / SUMMARY).exists() else {}
    certified = certified and summary.get("certified") is not False
    title = str(summary.get("title") or folder.resolve().name)
    if screenshot is None and _has_display():
        _open_window(snapshot, title, certified, clip)
        return None
    if is_of_solids(snapshot):
        file = Path(screenshot or folder / "tissue-3d.png")
        return draw_solids(snapshot, file, title=title, certified=certified, clip=clip)
    return draw_tissue(snapshot, Path(screenshot or folder / "tissue.png"), title=title, certified=certified)


def _has_display() -> bool:
    if sys.platform.startswith("linux"):
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return True


def _open_window(snapshot: Snapshot, title: str, certified: bool, clip: float | None) -> None:
    if is_of_solids(snapshot):
        solid_plot(snapshot, title=title, certified=certified, clip=clip).show()
        return
    import pyvista

    bulk = snapshot.bulk
    mesh = pyvista.UnstructuredGrid({bulk.cell_type: bulk.cells}, bulk.points + bulk.point_data["displacement"])
    mesh["X displacement"] = bulk.point_data["displacement"][:, 0]
    plotter: Any = pyvista.Plotter(title=title)  # its decorated methods have no types
    plotter.set_background("white")
    plotter.add_mesh(mesh, scalars="X displacement", cmap="viridis", lighting=False)
    plotter.add_mesh(mesh.extract_feature_edges(), color="black")
    if not certified:
        plotter.add_text(NOT_CERTIFIED, color="red", position="upper_edge")
    plotter.view_xy()
    plotter.show()
