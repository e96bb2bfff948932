"""One grid as a VTK XML file, `.vtu`: tags that describe the arrays, then the arrays themselves, compressed.

Each array follows the underscore of `AppendedData` at its offset: the number of blocks, the size of a whole block, the
size of a last part of a block, the compressed size of each block, and the blocks, by zlib. Here an array is one
block. Writing them takes less time than loading VTK's own writer.

References
----------
VTK User's Guide, 11th ed., Kitware 2010, section 19.3, "XML File Formats".
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.results.snapshot import Grid

_FAST = 1  # zlib's level: further ones take up to twice as long for 4 % of the size
_KINDS = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def vtu_bytes(grid: Grid, labels: Mapping[str, Any]) -> bytes:
    """Return the file of a grid.

    Parameters
    ----------
    grid : Grid
        Points, cells and the values on them; floats are kept as 64 bits, integers and booleans as 64-bit integers.
    labels : mapping of str to str or array
        The field data of the whole file.
    """
    file = _File()
    cells, nodes = grid.cells.shape
    file.open("VTKFile", type="UnstructuredGrid", version="1.0", byte_order="LittleEndian",
              header_type="UInt64", compressor="vtkZLibDataCompressor")  # fmt: skip
    file.open("UnstructuredGrid")
    file.section("FieldData", labels, of_grid=False)
    file.open("Piece", NumberOfPoints=len(grid.points), NumberOfCells=cells)
    file.section("PointData", grid.point_data)
    file.section("CellData", grid.cell_data)
    file.section("Points", {"points": np.asarray(grid.points, dtype=np.float64)})
    ends = nodes * np.arange(1, cells + 1)
    types = np.full(cells, grid.cell_type, dtype=np.uint8)
    file.section("Cells", {"connectivity": np.ravel(grid.cells), "offsets": ends, "types": types})
    file.close("Piece", "UnstructuredGrid")
    return file.ended()


class _File:
    """A file under way: its tags, and the arrays that will stand behind them."""

    def __init__(self) -> None:
        self._tags = ['<?xml version="1.0"?>']
        self._blocks: list[bytes] = []
        self._offset = 0

    def open(self, tag: str, **attributes: object) -> None:
        self._tags.append(f"<{_described(tag, attributes)}>")

    def close(self, *tags: str) -> None:
        self._tags.extend(f"</{tag}>" for tag in tags)

    def section(self, tag: str, arrays: Mapping[str, Any], *, of_grid: bool = True) -> None:
        """Add arrays inside `tag`; those that are not of the grid say themselves how long they are."""
        self.open(tag)
        for name, values in arrays.items():
            self._add(name, values, of_grid)
        self.close(tag)

    def _add(self, name: str, values: Any, of_grid: bool) -> None:
        if isinstance(values, str):
            array, count, described = np.frombuffer(values.encode() + b"\0", dtype=np.uint8), 1, ("Array", "String")
        else:
            array = _plain(values)
            count, described = len(array), ("DataArray", _KINDS[array.dtype.str[1:]])
        attributes: dict[str, object] = {"type": described[1], "Name": name}
        if array.ndim > 1:
            attributes["NumberOfComponents"] = array[:1].size
        if not of_grid:
            attributes["NumberOfTuples"] = count
        self._tags.append(f"<{_described(described[0], attributes | {'format': 'appended', 'offset': self._offset})}/>")
        self._append(array)

    def _append(self, array: NDArray[Any]) -> None:
        content = zlib.compress(np.ascontiguousarray(array), _FAST)
        sizes: Sequence[int] = (1, array.nbytes, 0, len(content)) if array.size else (0, 0, 0)
        block = np.array(sizes, dtype="<u8").tobytes() + (content if array.size else b"")
        self._blocks.append(block)
        self._offset += len(block)

    def ended(self) -> bytes:
        tags = "\n".join([*self._tags, '<AppendedData encoding="raw">', "_"])
        return b"".join([tags.encode(), *self._blocks, b"\n</AppendedData>\n</VTKFile>\n"])


def _described(tag: str, attributes: Mapping[str, object]) -> str:
    return " ".join([tag, *(f'{name}="{escape(str(value))}"' for name, value in attributes.items())])


def _plain(values: Any) -> NDArray[Any]:
    array = np.asarray(values)
    if array.dtype == np.uint8:
        return array
    return array.astype("<i8" if array.dtype.kind in "bui" else "<f8", copy=False)
