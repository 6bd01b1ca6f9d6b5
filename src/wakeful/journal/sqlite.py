"""The default journal: one SQLite file in WAL mode, through apsw's own SQLite."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import apsw

from wakeful.contracts.journal import JournalError, JournalStalled
from wakeful.facts.crash_points import reach
from wakeful.facts.lines import LOST_END, Line, Noted
from wakeful.facts.packs import Entry, last_position
from wakeful.journal.compaction.compactor import Compactor
from wakeful.journal.lock import FileLock
from wakeful.journal.migration import migrate
from wakeful.journal.opening import boot_id, connect, number, prepare
from wakeful.journal.packed.body import BodyWriter
from wakeful.journal.packed.row import ABOUT_COLUMNS, ROWS_COLUMNS, Row, rows_of
from wakeful.journal.reading import Reading
from wakeful.journal.retention import Retention
from wakeful.journal.schema import PRESENT

if TYPE_CHECKING:
    from types import TracebackType

_LOG = logging.getLogger("wakeful.journal")

_ROWS_PER_INSERT = 100

#: What may pass: the disk is full, cannot be written, or fails; somebody else writes (who has no business to).
_STALLS = (apsw.FullError, apsw.ReadOnlyError, apsw.IOError, apsw.CantOpenError, apsw.BusyError)


class SqliteJournal:
    """Append-only lines, keyed state and blobs in one file that only its owner may read.

    Args:
        path: the file; made, with its directory, where it is absent and ``read_only`` is false.
        read_only: look without the writer's lock; may be done beside a running writer.
        full_sync: ``synchronous=FULL`` (survives power loss) or NORMAL (survives a killed process).
        retention: how much of the past is kept; the documented defaults where None.
        vfs: the name of the SQLite VFS that does the reading and writing, for tests of a failing disk; None: the system's.

    Raises:
        JournalError: not a journal, a newer schema, locked by another process, unreadable.

    A journal of an older schema that is opened to be written is migrated first; ``migrated`` says from what, and to where it was
    copied before.
    """

    def __init__(
        self,
        path: Path,
        *,
        read_only: bool = False,
        full_sync: bool = True,
        retention: Retention | None = None,
        vfs: str | None = None,
    ) -> None:
        self.path = path
        self._lock: FileLock | None = None
        if read_only and not path.is_file():
            raise JournalError(f"there is no journal at {path}; make one with `wakeful run --journal {path} SOURCE`")
        new = not path.exists()
        if not read_only:
            prepare(path)
            self._lock = FileLock(path)
        try:
            reach("journal: file made")
            self.migrated = None if read_only else migrate(path)
            self._db = connect(path, read_only=read_only, full_sync=full_sync, vfs=vfs)
            self._reading = Reading(self._db, path)
            newest = f"SELECT last FROM about WHERE {PRESENT} ORDER BY id DESC LIMIT 1"
            self._last = number(self._db, f"SELECT coalesce(max(last), 0) FROM ({newest})")
        except apsw.Error as error:
            self._release()
            raise JournalError(f"{path} cannot be opened as a journal: {error}; name another file with --journal") from error
        except BaseException:  # Ctrl-C too: whoever catches it may open the file again
            self._release()
            raise
        self._words = self._reading.words
        self._writer = BodyWriter(self._words)
        self._boot = boot_id()
        self._compactor = Compactor(self._db, retention or Retention(), self._reading.row, self._put, self._writer)
        if self._lock is not None and not new and self._last < self._lock.known:
            self._tell_of_loss(self._lock.known)

    @property
    def last(self) -> int:
        """The last committed position, 0 for an empty journal."""
        return self._last

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """Append, in one transaction. After an error nothing of it is there and the journal can be used again.

        Raises:
            JournalStalled: the disk is full, read-only, or fails.
            JournalError: the positions don't continue the journal's, or what is to be written is no text.
        """
        last = self._last
        for entry in lines:
            if entry.position != last + 1:
                raise JournalError(f"line {entry.position} does not follow {last} in {self.path}")
            last = last_position(entry)
        try:
            with self._db:
                reach("commit: begun")
                rows = self._append(lines, last) if lines else []
                reach("commit: lines written")
                for key, value in state.items():
                    if value is None:
                        self._db.execute("DELETE FROM state WHERE key = ?", (key,))
                    else:
                        self._db.execute("INSERT OR REPLACE INTO state VALUES (?, ?)", (key, value))
                for name, value in blobs.items():
                    self._db.execute("INSERT OR IGNORE INTO blobs VALUES (?, ?)", (name, value))
                reach("commit: state written")
            self._words.settled()
        except _STALLS as error:
            raise JournalStalled(f"{self.path} could not be written: {error}; nothing of this commit was kept") from error
        except (apsw.Error, UnicodeEncodeError) as error:
            raise JournalError(f"{self.path} could not be written: {error}; nothing of this commit was kept") from error
        finally:
            self._words.withdraw()
        reach("commit: done")
        self._last = last
        if self._lock is not None and lines:
            self._lock.note(last)
        self._compactor.committed(lines, rows)

    def tidy(self, least_events: int = 0) -> bool:
        """Give up a little of what is older than the retention, in proportion to what was committed since the last time.

        To be done between two commits; a few milliseconds' work for each row committed, where there is anything to do.

        Args:
            least_events: begin where so many events are old enough; 0: where it is worth the while, as between commits.

        Returns:
            whether there is more to do at once.

        Raises:
            JournalError: it could not be written, or what is old is damaged; the journal is as it was before.
        """
        try:
            more = True
            steps = self._compactor.due()
            while more and steps:
                more = self._compactor.step(least_events)
                self._words.settled()
                steps -= 1
        except apsw.Error as error:
            raise JournalError(f"{self.path} could not be compacted: {error}; nothing of this step was done") from error
        finally:
            self._words.withdraw()
        return more

    def _tell_of_loss(self, known: int) -> None:
        """What was committed last is gone, with a write-ahead file that was lost, say, or because an older copy was put back."""
        detail = (
            f"positions {self._last + 1} to {known} had been committed and are gone: the write-ahead file {self.path.name}-wal "
            "was lost, or an older copy of the journal was put in its place"
        )
        _LOG.error("%s: %s; what was acknowledged in them has to be offered again", self.path, detail)
        before = next(iter(self._reading.lines(self._last - 1)), None) if self._last else None
        self.commit(
            [Line(self._last + 1, before.at_ns if before is not None else 0, Noted(what=LOST_END, detail=detail))], {}, {}
        )

    def _append(self, entries: Sequence[Entry], last: int) -> list[Row]:
        boot = int.from_bytes(self._words.constant(self._boot), "big")
        rows = list(rows_of(entries, self._writer))
        self._put(rows)
        self._insert("commits", 4, [last, time.time_ns(), time.monotonic_ns(), boot])
        return rows

    def _put(self, rows: Sequence[Row]) -> None:
        if self._words.new:
            self._insert("words", 2, [value for word in self._words.new for value in word])
        self._insert("rows", ROWS_COLUMNS, [value for row in rows for value in row.stored])
        self._insert("about", ABOUT_COLUMNS, [value for row in rows for value in row.about])

    def _insert(self, table: str, columns: int, values: list[int | str | bytes | None]) -> None:
        """One statement of many rows: executemany would hand over the interpreter lock per row."""
        slots = f"({','.join('?' * columns)})"
        for start in range(0, len(values), columns * _ROWS_PER_INSERT):
            part = values[start : start + columns * _ROWS_PER_INSERT]
            self._db.execute(f"INSERT INTO {table} VALUES {','.join([slots] * (len(part) // columns))}", part)

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The lines with position > ``after``, in order; those of packs one by one.

        Raises:
            JournalError: the file is damaged; the message names the row.
        """
        return self._reading.lines(after)

    def entries(self, after: int = 0) -> Iterator[Entry]:
        """What was committed with position > ``after``, in order, packs as packs.

        Raises:
            JournalError: the file is damaged; the message names the row.
        """
        return self._reading.entries(after)

    def lines_of(self, *, event: str | None = None, process: int | None = None, kinds: Sequence[str] = ()) -> Iterator[Line]:
        """The lines about an event or a process (or both), or of some kinds, in order; only rows that may hold any are read."""
        return self._reading.lines_of(event, process, kinds)

    def snapshot(self) -> AbstractContextManager[None]:
        """Within it everything is read as of one commit, whatever a writer adds meanwhile. For a journal opened to read.

        Raises:
            JournalError: the file is damaged.
        """
        return self._reading.snapshot()

    def commits(self) -> Iterator[int]:
        """The last position of each commit, in order: what was acknowledged as durable.

        Raises:
            JournalError: the file is damaged.
        """
        return self._reading.commits()

    def compacted(self) -> int:
        """The position up to which what is older than the retention was given up; 0: nothing was."""
        return number(self._db, "SELECT position FROM frontier")

    def state(self) -> dict[str, bytes]:
        """The keyed state as of the last commit.

        Raises:
            JournalError: the file is damaged.
        """
        return self._reading.state()

    def blob(self, name: str) -> bytes:
        """The bytes of a blob.

        Raises:
            JournalError: there is none of that name, or it cannot be read.
        """
        return self._reading.blob(name)

    def close(self) -> None:
        """Release the file. Committed lines stay, also where tidying up fails.

        Raises:
            JournalError: SQLite could not tidy up behind itself; the file is released all the same.
        """
        try:
            self._db.close()
        except apsw.Error as error:
            raise JournalError(f"{self.path} could not be tidied up on closing: {error}; what was committed stays") from error
        finally:
            self._release()

    def _release(self) -> None:
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def __enter__(self) -> SqliteJournal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def open_journal(
    path: Path,
    *,
    read_only: bool = False,
    full_sync: bool = True,
    retention: Retention | None = None,
    vfs: str | None = None,
) -> SqliteJournal:
    """Open, or make, the journal at ``path``. See SqliteJournal."""
    return SqliteJournal(path, read_only=read_only, full_sync=full_sync, retention=retention, vfs=vfs)
