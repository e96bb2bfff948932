"""One run to a folder: a lock that ends with the process that holds it, however that ends."""

from __future__ import annotations

import os
import socket
import sys
from contextlib import suppress
from pathlib import Path

from ngcell.errors import OutputError

LOCK = ".lock"


class FolderLock:
    """The right to write into a folder, held by at most one run at a time.

    The operating system takes it back when the process ends, so that a killed run leaves no folder locked. On a file
    system that knows no locks there is none.

    Parameters
    ----------
    folder : Path
        An existing folder.

    Raises
    ------
    OutputError
        If another run holds it, or the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._file = Path(folder) / LOCK
        while True:
            self._handle = self._taken(folder)
            if self._is_current():
                break
            os.close(self._handle)  # it was removed by its last holder between our opening and our locking it
        with suppress(OSError):  # a full disk: the folder is held without the holder's name
            os.truncate(self._handle, 0)
            os.write(self._handle, f"process {os.getpid()} on {socket.gethostname()}".encode())

    def release(self) -> None:
        """Let others have it."""
        with suppress(OSError):
            self._file.unlink()
        with suppress(OSError):
            os.close(self._handle)

    def _taken(self, folder: Path) -> int:
        try:
            handle = os.open(self._file, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise OutputError(
                f"cannot use {folder} as the result folder: {error.strerror}; choose another folder"
            ) from error
        try:
            _lock(handle)
        except BlockingIOError:
            holder = os.read(handle, 200).decode(errors="replace") or "another process"
            os.close(handle)
            raise OutputError(
                f"{folder} is in use: {holder} writes its run there; wait for its end or choose another folder"
            ) from None
        except OSError:
            pass  # no locks here
        return handle

    def _is_current(self) -> bool:
        with suppress(OSError):
            return os.path.samestat(os.fstat(self._handle), os.stat(self._file))
        return False


if sys.platform == "win32":
    import msvcrt

    def _lock(handle: int) -> None:
        try:
            # Beyond the text, which others may read meanwhile.
            os.lseek(handle, 1000, os.SEEK_SET)
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError as error:
            raise BlockingIOError from error
        finally:
            os.lseek(handle, 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(handle: int) -> None:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
