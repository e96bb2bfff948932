"""How the process takes memory.

numpy asks the system for huge pages for every array of 4 MiB or more (`NUMPY_MADVISE_HUGEPAGE`), which have to be found
and cleared in whole. Most such arrays here live for a few milliseconds: without huge pages nine cells take 6 % less
processor time, 35 cells as much.
"""

from __future__ import annotations

import os


def take_small_pages() -> None:
    """Let numpy do without huge pages, unless the user has chosen; to be called before numpy is imported."""
    os.environ.setdefault("NUMPY_MADVISE_HUGEPAGE", "0")
