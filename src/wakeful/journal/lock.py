"""One writer to a journal: an advisory lock beside the file, naming the holder's pid and the last position that it committed."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

from wakeful.contracts.journal import JournalError


class JournalLocked(JournalError):
    """Another process writes the journal; ``holder`` is its pid, or ``unknown``."""

    def __init__(self, message: str, holder: str) -> None:
        super().__init__(message)
        self.holder = holder


#: The file's size: it is written over in place, which a full disk lets one do too.
_BYTES = 64


class FileLock:
    """Held until ``release`` or until the process ends, however it ends.

    ``known``: the last position that an earlier writer noted here after its commit; 0: none. It stands outside SQLite's files, so
    a journal that comes to less has lost its end.

    Raises:
        JournalLocked: another process holds it; the message names its pid.
    """

    def __init__(self, journal: Path) -> None:
        self._path = journal.with_name(journal.name + ".lock")
        self._file = os.open(self._path, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = self._read()[0] or "unknown"
            os.close(self._file)
            raise JournalLocked(
                f"{journal} is being written by process {holder}; stop it, or name another file with --journal", holder
            ) from None
        found = self._read()[1]
        self.known = int(found) if found.isdigit() else 0
        self.note(self.known)

    def note(self, last: int) -> None:
        """Everything up to that position is committed. Costs a write that nobody waits for; a failing disk is not complained of,
        since what is noted only serves to tell of a loss."""
        with suppress(OSError):
            os.pwrite(self._file, f"{os.getpid()}\n{last}\n".encode().ljust(_BYTES), 0)

    def release(self) -> None:
        """Let the next writer in."""
        os.close(self._file)

    def _read(self) -> tuple[str, str]:
        """The holder's pid, and the last position that was noted."""
        pid, _, last = os.pread(self._file, _BYTES, 0).decode(errors="replace").partition("\n")
        return pid.strip(), last.strip()
