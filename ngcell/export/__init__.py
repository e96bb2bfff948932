"""Results on disk: tables, VTK series, pictures, the summary, and the folder that holds them.

VTK, pyvista and matplotlib are imported inside the functions that need them, so that a run starts fast.
"""

from ngcell.export.curves import draw_curves
from ngcell.export.debonding import draw_debonding
from ngcell.export.ensemble import EnsembleFolder, spread_table
from ngcell.export.folder import ResultFolder
from ngcell.export.layout_picture import draw_layout
from ngcell.export.ownership import restore_case
from ngcell.export.picture import draw_tissue
from ngcell.export.restart import Restart, cannot_resume, read_restart
from ngcell.export.series import SnapshotSeries, count_snapshots, read_last_snapshot, read_snapshot
from ngcell.export.small_picture import small_tissue
from ngcell.export.summary import accepted_steps, read_summary, write_summary
from ngcell.export.tables import RecordTable, read_records
from ngcell.export.view import show

__all__ = [
    "EnsembleFolder",
    "RecordTable",
    "Restart",
    "ResultFolder",
    "SnapshotSeries",
    "accepted_steps",
    "cannot_resume",
    "count_snapshots",
    "draw_curves",
    "draw_debonding",
    "draw_layout",
    "draw_tissue",
    "read_last_snapshot",
    "read_records",
    "read_restart",
    "read_snapshot",
    "read_summary",
    "restore_case",
    "show",
    "small_tissue",
    "spread_table",
    "write_summary",
]
