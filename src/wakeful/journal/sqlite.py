"""The default journal: one SQLite file in WAL mode, through apsw's own SQLite."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import apsw
import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.facts.crash_points import reach
from wakeful.facts.lines import Line
from wakeful.facts.packs import Entry, expanded
from wakeful.journal.lock import FileLock
from wakeful.journal.reading import Reading
from wakeful.journal.schema import APPLICATION_ID, MIGRATIONS, VERSION

if TYPE_CHECKING:
    from types import TracebackType

_ROWS_PER_INSERT = 100


class SqliteJournal:
    """Append-only lines, keyed state and blobs in one file that only its owner may read.

    Args:
        path: the file; made, with its directory, where it is absent and ``read_only`` is false.
        read_only: look without the writer's lock; may be done beside a running writer.
        full_sync: ``synchronous=FULL`` (survives power loss) or NORMAL (survives a killed process).
        vfs: the name of the SQLite VFS that does the reading and writing, for tests of a failing disk; None: the system's.

    Raises:
        JournalError: not a journal, a newer schema, locked by another process, unreadable.
    """

    def __init__(self, path: Path, *, read_only: bool = False, full_sync: bool = True, vfs: str | None = None) -> None:
        self.path = path
        self._vfs = vfs
        self._encode = msgspec.json.Encoder().encode
        self._lock: FileLock | None = None
        if read_only and not path.is_file():
            raise JournalError(f"there is no journal at {path}; make one with `wakeful run --journal {path} SOURCE`")
        if not read_only:
            self._prepare()
            self._lock = FileLock(path)
        try:
            reach("journal: file made")
            self._db = self._connect(read_only, full_sync)
            self._reading = Reading(self._db, path)
            self._last = _number(self._db, "SELECT coalesce(max(position), 0) FROM lines")
        except apsw.Error as error:
            self._release()
            raise JournalError(f"{path} cannot be opened as a journal: {error}; name another file with --journal") from error
        except BaseException:  # Ctrl-C too: whoever catches it may open the file again
            self._release()
            raise
        self._boot = _boot_id()

    def _prepare(self) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            if not self.path.exists():
                os.close(os.open(self.path, os.O_CREAT | os.O_RDWR, 0o600))
                _sync_directory(self.path.parent)
            else:
                os.close(os.open(self.path, os.O_RDWR))
        except OSError as error:
            raise JournalError(
                f"{self.path} cannot be written: {error.strerror}; name another file with --journal or free the place"
            ) from error

    def _connect(self, read_only: bool, full_sync: bool) -> apsw.Connection:
        flags = apsw.SQLITE_OPEN_READONLY if read_only else apsw.SQLITE_OPEN_READWRITE
        db = apsw.Connection(str(self.path), flags=flags, vfs=self._vfs)
        db.set_busy_timeout(5_000)
        version = _number(db, "PRAGMA user_version")
        application = _number(db, "PRAGMA application_id")
        tables = _number(db, "SELECT count(*) FROM sqlite_schema")
        if application != APPLICATION_ID and tables:
            raise JournalError(f"{self.path} is a database, but not a wakeful journal; name another file with --journal")
        if version > VERSION:
            raise JournalError(
                f"{self.path} has schema {version}, this wakeful knows {VERSION}: install the newer wakeful that wrote it"
            )
        if read_only:
            if not tables:
                raise JournalError(f"{self.path} is empty; fill it with `wakeful run --journal {self.path} SOURCE`")
            return db
        db.execute("PRAGMA journal_mode=WAL")
        db.execute(f"PRAGMA synchronous={'FULL' if full_sync else 'NORMAL'}")
        if version < VERSION:
            self._migrate(db, version)
        return db

    @staticmethod
    def _migrate(db: apsw.Connection, version: int) -> None:
        with db:
            for step in MIGRATIONS[version:]:
                db.execute(step)
            reach("journal: schema written")
            db.execute(f"PRAGMA application_id={APPLICATION_ID}")
            db.execute(f"PRAGMA user_version={VERSION}")

    @property
    def last(self) -> int:
        """The last committed position, 0 for an empty journal."""
        return self._last

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """Append, in one transaction. After an error nothing of it is there and the journal can be used again.

        Raises:
            JournalError: the positions don't continue the journal's, or SQLite could not write (disk full, read-only).
        """
        unpacked = list(expanded(lines))
        for expected, line in enumerate(unpacked, self._last + 1):
            if line.position != expected:
                raise JournalError(f"line {line.position} does not follow {expected - 1} in {self.path}")
        rows = [self._row(line) for line in unpacked]
        try:
            with self._db:
                reach("commit: begun")
                for start in range(0, len(rows), _ROWS_PER_INSERT):
                    part = rows[start : start + _ROWS_PER_INSERT]
                    # One statement of many rows: executemany would hand over the interpreter lock per row.
                    slots = ",".join(["(?,?,?,?,?,?)"] * len(part))
                    self._db.execute(f"INSERT INTO lines VALUES {slots}", [value for row in part for value in row])
                reach("commit: lines written")
                for key, value in state.items():
                    if value is None:
                        self._db.execute("DELETE FROM state WHERE key = ?", (key,))
                    else:
                        self._db.execute("INSERT OR REPLACE INTO state VALUES (?, ?)", (key, value))
                for name, value in blobs.items():
                    self._db.execute("INSERT OR IGNORE INTO blobs VALUES (?, ?)", (name, value))
                if unpacked:
                    self._db.execute(
                        "INSERT INTO commits VALUES (?, ?, ?, ?)",
                        (unpacked[-1].position, time.time_ns(), time.monotonic_ns(), self._boot),
                    )
                reach("commit: state written")
        except apsw.Error as error:
            raise JournalError(f"{self.path} could not be written: {error}; nothing of this commit was kept") from error
        reach("commit: done")
        if unpacked:
            self._last = unpacked[-1].position

    def _row(self, line: Line) -> tuple[int, int, str, str | None, int | None, str]:
        record = line.record
        event = getattr(record, "event", None)
        if event is not None and not isinstance(event, str):
            event = event.id
        process = getattr(record, "process", None)
        return (
            line.position,
            line.at_ns,
            type(record).__name__.lower(),
            event or None,
            process or None,
            self._encode(record).decode(),
        )

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The lines with position > ``after``, in order.

        Raises:
            JournalError: the file is damaged; the message names the line.
        """
        return self._reading.lines("position > ?", [after])

    def entries(self, after: int = 0) -> Iterator[Entry]:
        """What was committed with position > ``after``, in order: line by line, for packs are kept as their lines.

        Raises:
            JournalError: the file is damaged; the message names the line.
        """
        return self.lines(after)

    def lines_of(self, *, event: str | None = None, process: int | None = None, kinds: Sequence[str] = ()) -> Iterator[Line]:
        """The lines about an event or a process (or both), or of some kinds, in order; looked up by index."""
        where: list[str] = []
        values: list[str | int] = []
        if event is not None:
            where.append("event = ?")
            values.append(event)
        if process is not None:
            where.append("process = ?")
            values.append(process)
        if kinds:
            where.append(f"kind IN ({','.join('?' * len(kinds))})")
            values.extend(kinds)
        return self._reading.lines(" AND ".join(where) or "1", values)

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


def open_journal(path: Path, *, read_only: bool = False, full_sync: bool = True, vfs: str | None = None) -> SqliteJournal:
    """Open, or make, the journal at ``path``. See SqliteJournal."""
    return SqliteJournal(path, read_only=read_only, full_sync=full_sync, vfs=vfs)


def _number(db: apsw.Connection, query: str) -> int:
    return int(next(db.execute(query))[0])


def _sync_directory(directory: Path) -> None:
    """Make the names in it durable: the journal's own name must outlive a loss of power as its content does."""
    handle = os.open(directory, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _boot_id() -> str:
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return ""
