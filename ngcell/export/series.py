"""A time series of snapshots that ParaView and pyvista open: `tissue.pvd` and its `.vtu` files.

Only VTK's XML writer is imported, not pyvista, which takes three times the processor time. The writer fills a string,
and Python writes the file, so that a full disk shows as an error and never as half a file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import OutputError
from ngcell.export.atomic import replace_file
from ngcell.export.silent import silent_vtk
from ngcell.results.snapshot import Grid, Snapshot

if TYPE_CHECKING:
    import pyvista
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

CERTIFIED = "certified"
NOT_CERTIFIED = "NOT CERTIFIED"
VERDICT = "ngcell_verdict"
#: What reading a damaged file may raise.
_UNREADABLE = (OSError, SyntaxError, LookupError, TypeError, ValueError, AttributeError, RuntimeError)


@dataclass(frozen=True, slots=True)
class _Entry:
    number: int
    step: int
    load_factor: float
    plate_displacement: float


class SnapshotSeries:
    """Snapshots in a folder: `<name>_0000.vtu` (bodies), `walls_0000.vtu` (walls) and `<name>.pvd` over both.

    In the `.pvd` the bodies are part 0 and the walls are part 1. The time of a snapshot is its plate displacement if
    that increases from snapshot to snapshot, else its load factor if that does, else the number of its step. The field
    data `ngcell_verdict` of each file says whether its step is certified.

    Parameters
    ----------
    folder : Path
        An existing folder.
    name : str
        Stem of the `.pvd` file.
    snapshots : sequence of (int, float, float)
        Step, load factor and plate displacement of the snapshots that are there already.
    checksums : mapping of str to int
        CRC-32 of their files, by file name.

    Attributes
    ----------
    checksums : dict of str to int
        As the parameter, of all files written so far.
    """

    def __init__(
        self,
        folder: Path,
        name: str = "tissue",
        *,
        snapshots: Sequence[tuple[int, float, float]] = (),
        checksums: Mapping[str, int] | None = None,
    ) -> None:
        self.checksums = dict(checksums or {})
        self.folder = Path(folder)
        self.name = name
        self._entries = [_Entry(number, *snapshot) for number, snapshot in enumerate(snapshots)]

    @property
    def snapshots(self) -> tuple[tuple[int, float, float], ...]:
        """Step, load factor and plate displacement of each snapshot."""
        return tuple((entry.step, entry.load_factor, entry.plate_displacement) for entry in self._entries)

    def write_list(self) -> None:
        """Write the `.pvd` anew."""
        replace_file(self.folder / f"{self.name}.pvd", self._pvd(self._entries))

    @property
    def damage(self) -> str | None:
        """Which file of a snapshot is missing or is not what was written, in words; None if none is."""
        for name in (name for entry in self._entries for name in self._parts(entry)):
            file = self.folder / name
            if not file.is_file():
                return f"{name} is missing"
            if name in self.checksums and crc32(file.read_bytes()) != self.checksums[name]:
                return f"{name} is damaged"
        return None

    def append(self, snapshot: Snapshot, *, certified: bool) -> None:
        """Write the two files of a snapshot and then list them in the `.pvd`.

        Raises
        ------
        OutputError
            If a file cannot be written; the series is then as it was.
        """
        number = len(self._entries)
        entry = _Entry(number, snapshot.step, snapshot.load_factor, snapshot.plate_displacement)
        files = [self.folder / file for file in self._parts(entry)]
        try:
            for file, grid in zip(files, (snapshot.bulk, snapshot.walls), strict=True):
                content = _vtu(grid, _labels(snapshot, certified))
                replace_file(file, content)
                self.checksums[file.name] = crc32(content)
            replace_file(self.folder / f"{self.name}.pvd", self._pvd([*self._entries, entry]))
        except OutputError:
            for file in files:
                with suppress(OSError):
                    file.unlink()
            raise
        self._entries.append(entry)

    def _parts(self, entry: _Entry) -> tuple[str, str]:
        return f"{self.name}_{entry.number:04d}.vtu", f"walls_{entry.number:04d}.vtu"

    def _pvd(self, entries: Sequence[_Entry]) -> bytes:
        lines = [
            f'    <DataSet timestep="{time!r}" group="" part="{part}" file="{file}"/>'
            for entry, time in zip(entries, _times(entries), strict=True)
            for part, file in enumerate(self._parts(entry))
        ]
        head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">'
        return "\n".join([head, "  <Collection>", *lines, "  </Collection>", "</VTKFile>", ""]).encode()


def read_last_snapshot(folder: Path, name: str = "tissue") -> tuple[Snapshot, bool]:
    """Read the last snapshot of a series, and whether it is certified; raise as `read_snapshot` does."""
    return read_snapshot(folder, -1, name)


def count_snapshots(folder: Path, name: str = "tissue") -> int:
    """Return the number of snapshots of a series; 0 where there is none that can be read."""
    try:
        with silent_vtk():
            return len(_open_series(Path(folder) / f"{name}.pvd").time_values)
    except _UNREADABLE:
        return 0


def read_snapshot(folder: Path, number: int, name: str = "tissue") -> tuple[Snapshot, bool]:
    """Read a snapshot of a series, and whether it is certified.

    Parameters
    ----------
    folder : Path
        The result of a run, finished or not.
    number : int
        Place in the series, from 0; -1 is the last.
    name : str
        Stem of the `.pvd` file.

    Raises
    ------
    OutputError
        If the folder holds no such series, or it cannot be read.
    """
    path = Path(folder) / f"{name}.pvd"
    if not path.is_file():
        raise OutputError(f"{folder} holds no {path.name}: not a result, or no step was accepted")
    try:
        with silent_vtk():
            reader = _open_series(path)
            reader.set_active_time_value(reader.time_values[number])
            bulk, walls = reader.read()
        labels, _ = bulk.field_data, walls.field_data[VERDICT]  # which a damaged file does not have
        step, load_factor, displacement = (labels[key][0] for key in ("step", "load_factor", "plate_displacement"))
        snapshot = Snapshot(int(step), float(load_factor), float(displacement), _grid(bulk), _grid(walls))
        return snapshot, labels[VERDICT][0] == CERTIFIED
    except _UNREADABLE as error:
        reason = str(error).partition("\n")[0] or type(error).__name__
        if isinstance(error, LookupError):
            reason = "a file that it lists is not whole"
        place = "the last snapshot" if number < 0 else f"snapshot {number}"
        raise OutputError(f"cannot read {place} of {path}: {reason}; is it damaged?") from error


def _open_series(path: Path) -> Any:
    import pyvista

    open_reader: Any = pyvista.get_reader  # it is not annotated
    return open_reader(path)


def _times(entries: Sequence[_Entry]) -> list[float]:
    for times in (
        [float(entry.plate_displacement) for entry in entries],
        [float(entry.load_factor) for entry in entries],
    ):
        if all(later > earlier for earlier, later in zip(times, times[1:], strict=False)):
            return times
    return [float(entry.step) for entry in entries]


def _labels(snapshot: Snapshot, certified: bool) -> dict[str, Any]:
    return {
        VERDICT: CERTIFIED if certified else NOT_CERTIFIED,
        "step": np.array([snapshot.step], dtype=np.int64),
        "load_factor": np.array([snapshot.load_factor], dtype=np.float64),
        "plate_displacement": np.array([snapshot.plate_displacement], dtype=np.float64),
    }


def _vtu(grid: Grid, labels: Mapping[str, Any]) -> bytes:
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(_vtk_grid(grid, labels))
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToLZ4()
    writer.SetWriteToOutputString(True)
    writer.Write()
    content = writer.GetOutputString()
    # VTK's Python layer hands over str when the bytes happen to be valid UTF-8.
    return content.encode() if isinstance(content, str) else content


def _vtk_grid(grid: Grid, labels: Mapping[str, Any]) -> vtkUnstructuredGrid:
    from vtkmodules.util import numpy_support
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

    points, cells, result = vtkPoints(), vtkCellArray(), vtkUnstructuredGrid()
    points.SetData(_vtk_array("points", np.asarray(grid.points, dtype=np.float64)))
    connectivity = np.array(grid.cells, dtype=np.int64).ravel()
    to_vtk: Any = numpy_support.numpy_to_vtkIdTypeArray  # it is not annotated
    cells.SetData(grid.cells.shape[1], to_vtk(connectivity, deep=True))
    result.SetPoints(points)
    result.SetCells(grid.cell_type, cells)
    for data, place in (
        (grid.point_data, result.GetPointData()),
        (grid.cell_data, result.GetCellData()),
        (labels, result.GetFieldData()),
    ):
        for array in _vtk_arrays(data):
            place.AddArray(array)
    return result


def _vtk_arrays(data: Mapping[str, Any]) -> Iterator[Any]:
    for name, values in data.items():
        yield _vtk_string(name, values) if isinstance(values, str) else _vtk_array(name, values)


def _vtk_array(name: str, values: NDArray[Any]) -> Any:
    from vtkmodules.util import numpy_support

    to_vtk: Any = numpy_support.numpy_to_vtk  # it is not annotated
    whole = np.asarray(values).dtype.kind in "bui"
    array = to_vtk(np.ascontiguousarray(values, dtype=np.int64 if whole else np.float64), deep=True)
    array.SetName(name)
    return array


def _vtk_string(name: str, text: str) -> Any:
    from vtkmodules.vtkCommonCore import vtkStringArray

    array = vtkStringArray()
    array.SetName(name)
    array.InsertNextValue(text)
    return array


def _grid(dataset: pyvista.UnstructuredGrid) -> Grid:
    cells: list[Any] = list(dataset.cells_dict.items()) or [(0, np.empty((0, 0), dtype=np.int64))]
    if len(cells) != 1:
        raise ValueError(f"cells of {len(cells)} types where one is expected")
    cell_type, connectivity = cells[0]
    return Grid(
        points=np.array(dataset.points, dtype=np.float64),
        cells=np.array(connectivity),
        cell_type=int(cell_type),
        point_data={name: np.array(values) for name, values in dataset.point_data.items()},
        cell_data={name: np.array(values) for name, values in dataset.cell_data.items()},
    )
