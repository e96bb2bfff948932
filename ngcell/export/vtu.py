"""An unstructured grid as the text of a `.vtu` file, in VTK's XML format.

Importing VTK's own writer takes longer than writing the files of a small run. The format is described at
https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html; arrays are appended as raw bytes, each
compressed as one block.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import quoteattr
from zlib import compress

import numpy as np
from numpy.typing import NDArray

from ngcell.results.snapshot import Grid

#: Level of compression: the fastest, since numbers with many digits get little smaller by more work.
_LEVEL = 1
_TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def vtu(grid: Grid, labels: Mapping[str, Any]) -> bytes:
    """Return the content of a file.

    Parameters
    ----------
    grid : Grid
        Points, cells, and the values on them.
    labels : mapping of str to str or array
        What the file says of itself, as field data.
    """
    count, nodes = grid.cells.shape
    cells = {
        "connectivity": grid.cells.ravel(),
        "offsets": nodes * np.arange(1, count + 1),
        "types": np.full(count, grid.cell_type, dtype=np.uint8),
    }
    arrays = _Arrays()
    content = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64" '
        'compressor="vtkZLibDataCompressor">',
        "<UnstructuredGrid>",
        *arrays.section("FieldData", labels),
        f'<Piece NumberOfPoints="{len(grid.points)}" NumberOfCells="{count}">',
        *arrays.section("PointData", grid.point_data),
        *arrays.section("CellData", grid.cell_data),
        *arrays.section("Points", {"Points": np.asarray(grid.points, dtype=np.float64)}),
        *arrays.section("Cells", cells),
        "</Piece>",
        "</UnstructuredGrid>",
        '<AppendedData encoding="raw">\n_',
    ]
    return b"".join(["\n".join(content).encode(), *arrays.blocks, b"\n</AppendedData>\n</VTKFile>\n"])


class _Arrays:
    """The arrays of a file, which follow its text one after the other."""

    def __init__(self) -> None:
        self.blocks: list[bytes] = []
        self._size = 0

    def section(self, name: str, data: Mapping[str, Any]) -> list[str]:
        """Append arrays, and return the lines that describe them."""
        return [f"<{name}>", *(self._described(each, values) for each, values in data.items()), f"</{name}>"]

    def _described(self, name: str, values: str | NDArray[Any]) -> str:
        if isinstance(values, str):
            self._append(values.encode() + b"\0")
            return f'<Array type="String" Name={quoteattr(name)} NumberOfTuples="1" {self._place()}/>'
        values = np.asarray(values)
        kind = "u1" if values.dtype == np.uint8 else "i8" if values.dtype.kind in "bui" else "f8"
        self._append(np.ascontiguousarray(values, dtype=f"<{kind}").tobytes())
        shape = f'NumberOfComponents="{values[0].size if len(values) else 1}" NumberOfTuples="{len(values)}"'
        return f'<DataArray type="{_TYPES[kind]}" Name={quoteattr(name)} {shape} {self._place()}/>'

    def _append(self, raw: bytes) -> None:
        """Append an array: number of blocks, their size, that of the last one if it is partial, and sizes within."""
        within = compress(raw, _LEVEL)
        sizes = (1, len(raw), 0, len(within)) if raw else (0, 0, 0)
        self.blocks.append(np.array(sizes, dtype="<u8").tobytes() + (within if raw else b""))

    def _place(self) -> str:
        """Return where the array appended last begins."""
        offset, self._size = self._size, self._size + len(self.blocks[-1])
        return f'format="appended" offset="{offset}"'
