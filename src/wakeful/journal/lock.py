"""One writer to a journal: an advisory lock beside the file, naming the holder's pid."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from wakeful.contracts.journal import JournalError


class JournalLocked(JournalError):
    """Another process writes the journal; ``holder`` is its pid, or ``unknown``."""

    def __init__(self, message: str, holder: str) -> None:
        super().__init__(message)
        self.holder = holder


class FileLock:
    """Held until ``release`` or until the process ends, however it ends.

    Raises:
        JournalLocked: another process holds it; the message names its pid.
    """

    def __init__(self, journal: Path) -> None:
        self._path = journal.with_name(journal.name + ".lock")
        self._file = os.open(self._path, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.read(self._file, 32).decode(errors="replace").strip() or "unknown"
            os.close(self._file)
            raise JournalLocked(
                f"{journal} is being written by process {holder}; stop it, or name another file with --journal", holder
            ) from None
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, f"{os.getpid()}\n".encode(), 0)

    def release(self) -> None:
        """Let the next writer in."""
        os.close(self._file)
