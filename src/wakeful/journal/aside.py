"""Where parked processes are put away: a private temporary database of SQLite's, which is gone when the mind ends."""

from __future__ import annotations

from contextlib import suppress
from types import TracebackType

import apsw

from wakeful.contracts.aside import AsideFull

#: So much of it stays in memory, in KiB; the rest is on the disk.
CACHE_KIB = 2_000


#: What a temporary folder that has no room, or fails, may raise.
_NO_ROOM = (apsw.FullError, apsw.IOError, apsw.CantOpenError, apsw.ReadOnlyError, apsw.BusyError)


class AsideFile:
    """Processes by number in a file that only this process can open.

    SQLite makes it on first use, readable by the owner only and without a name, in the folder that ``SQLITE_TMPDIR`` or
    ``TMPDIR`` names, else in /var/tmp. It is never synchronised: after a crash the journal is folded anew.
    """

    def __init__(self) -> None:
        self._db: apsw.Connection | None = None

    def __enter__(self) -> AsideFile:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def put(self, process: int, text: bytes) -> None:
        """Put a process away.

        Raises:
            AsideFull: the temporary folder has no room, or cannot be written.
        """
        try:
            self._opened().execute("INSERT OR REPLACE INTO aside VALUES (?, ?)", (process, text))
        except _NO_ROOM as error:
            raise AsideFull(f"waiting processes cannot be parked: {error}; make room in SQLITE_TMPDIR") from error

    def take(self, process: int) -> bytes:
        """Take it back. Raises KeyError where it was not put away."""
        db = self._opened()
        rows = db.execute("SELECT text FROM aside WHERE process = ?", (process,)).fetchall()
        if not rows or not isinstance(rows[0][0], bytes):
            raise KeyError(process)
        with suppress(*_NO_ROOM):  # what stays behind is written over, or goes with the file
            db.execute("DELETE FROM aside WHERE process = ?", (process,))
        return rows[0][0]

    def close(self) -> None:
        """Give the file up, with all that is in it."""
        if self._db is not None:
            self._db.close()
            self._db = None

    def _opened(self) -> apsw.Connection:
        if self._db is None:
            self._db = apsw.Connection("")
            self._db.execute(f"PRAGMA journal_mode = MEMORY; PRAGMA cache_size = -{CACHE_KIB}")
            self._db.execute("CREATE TABLE aside (process INTEGER PRIMARY KEY, text BLOB NOT NULL)")
        return self._db
