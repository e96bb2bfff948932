"""The picture of three-dimensional bodies: coloured by X displacement, open walls in red.

It needs a graphics library that can draw without a display, so only `ngcell view` makes it; a run draws the upper ends
of prisms, by `ngcell.export.picture`.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from ngcell.export.atomic import replace_file
from ngcell.export.series import NOT_CERTIFIED
from ngcell.results.snapshot import Grid, Snapshot

#: VTK types of three-dimensional cells.
SOLIDS = (24, 29, 32)
#: Share of the largest gap above which a wall is marked as open.
_MARKED = 0.1
_SIZE = (1400, 1000)


def is_of_solids(snapshot: Snapshot) -> bool:
    """Return whether the bodies of a snapshot are three-dimensional."""
    return snapshot.bulk.cell_type in SOLIDS


def solid_plot(snapshot: Snapshot, *, title: str, certified: bool, clip: float | None = None, **window: Any) -> Any:
    """Return a pyvista plotter that shows a snapshot of three-dimensional bodies.

    Parameters
    ----------
    snapshot : Snapshot
        One of three-dimensional bodies.
    title : str
        Heading; may be empty.
    certified : bool
        Whether the result passed every check.
    clip : float, optional
        Share of the height in the reference state above which bodies are cut off, in (0, 1]; by default nothing is.
    window
        Keyword arguments of `pyvista.Plotter`.
    """
    import pyvista

    plotter: Any = pyvista.Plotter(**window)  # its decorated methods have no types
    plotter.set_background("white")
    _add_bodies(plotter, snapshot, clip)
    largest = _add_open_walls(plotter, snapshot, clip)
    moved = snapshot.plate_displacement
    place = f"plate displacement {moved:.4g}" if moved else f"load factor {snapshot.load_factor:.4g}"
    note = f"{place}; red: gap above {_MARKED * largest:.2g}" if largest > 0 else place
    plotter.add_text(f"{title}\n{note}", color="black", font_size=11, position="upper_left")
    if not certified:
        plotter.add_text(NOT_CERTIFIED, color="red", position="upper_right")
    plotter.camera_position = [(-0.5, -0.9, 1.1), (0, 0, 0), (0, 1, 0)]
    plotter.reset_camera()
    return plotter


def draw_solids(snapshot: Snapshot, path: Path, *, title: str, certified: bool, clip: float | None = None) -> Path:
    """Draw three-dimensional bodies into a PNG file, without a display; parameters as for `solid_plot`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    plotter = solid_plot(
        snapshot, title=title, certified=certified, clip=clip, off_screen=True, window_size=list(_SIZE)
    )
    image = io.BytesIO()
    plotter.screenshot(image)
    plotter.close()
    replace_file(Path(path), image.getvalue())
    return Path(path)


def _add_bodies(plotter: Any, snapshot: Snapshot, clip: float | None) -> None:
    bodies = _moved(snapshot.bulk)
    bodies["X displacement"] = snapshot.bulk.point_data["displacement"][:, 0]
    bodies = _below(bodies, snapshot, snapshot.bulk, clip)
    surface = bodies.extract_surface(nonlinear_subdivision=2, algorithm="dataset_surface")
    bar = {"color": "black", "title": "X displacement", "vertical": True}
    plotter.add_mesh(surface, scalars="X displacement", cmap="viridis", scalar_bar_args=bar, ambient=0.35)
    plotter.add_mesh(surface.extract_feature_edges(30), color="black", line_width=1.5)


def _add_open_walls(plotter: Any, snapshot: Snapshot, clip: float | None) -> float:
    """Mark open walls; return the largest gap of all."""
    gap = np.nan_to_num(snapshot.walls.point_data["gap"], nan=0.0)
    largest = float(gap.max(initial=0.0))
    walls = _moved(snapshot.walls)
    walls["gap"] = gap
    walls = _below(walls, snapshot, snapshot.walls, clip)
    opened = walls.threshold(_MARKED * largest, scalars="gap", method="upper") if largest > 0 else None
    if opened is not None and opened.n_points:
        drawn = plotter.add_mesh(opened, color="#d21f1f", opacity=0.55, show_scalar_bar=False)
        # Walls coincide with the surface of the bodies; drawn as if a little nearer, they are not hidden by it.
        drawn.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        drawn.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -2.0)
    return largest


def _below(shown: Any, snapshot: Snapshot, grid: Grid, clip: float | None) -> Any:
    """Return the part that is, in the reference state, below a share of the height of all bodies."""
    if clip is None:
        return shown
    height = snapshot.bulk.points[:, 2]
    shown["height"] = grid.points[:, 2]
    return shown.clip_scalar(scalars="height", value=float(height.min() + clip * np.ptp(height)))


def _moved(grid: Grid) -> Any:
    import pyvista

    return pyvista.UnstructuredGrid({grid.cell_type: grid.cells}, grid.points + grid.point_data["displacement"])
