"""What a SQLite journal holds, read row by row: what cannot be read is named with its place, never a crash."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import apsw
import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import AnyRecord, Line

if TYPE_CHECKING:
    from apsw import SQLiteValue, SQLiteValues

_Row = tuple["SQLiteValue", ...]


class Reading:
    """Reads the tables of one open journal. Every method raises JournalError where the file is damaged."""

    def __init__(self, db: apsw.Connection, path: Path) -> None:
        self._db = db
        self._path = path
        self._decode = msgspec.json.Decoder(AnyRecord).decode

    def lines(self, where: str, values: Sequence[str | int]) -> Iterator[Line]:
        """The lines that a condition in SQL holds for, in order."""
        # As bytes: damaged text would fail in SQLite's own decoding, which can't say at which line.
        query = f"SELECT position, at_ns, CAST(record AS BLOB) FROM lines WHERE {where} ORDER BY position"
        reached: SQLiteValue = 0
        try:
            for row in self._db.execute(query, values):
                reached = row[0]
                line = self._line(row)
                yield line
        except apsw.Error as error:
            raise self._damaged(f"what follows line {reached}", error) from error

    def state(self) -> dict[str, bytes]:
        """The keyed state."""
        return {str(key): self._bytes(f"its state {key!r}", value) for key, value in self._rows("SELECT key, value FROM state")}

    def blob(self, name: str) -> bytes:
        """The bytes of a blob; JournalError also where there is none of that name."""
        for (value,) in self._rows("SELECT value FROM blobs WHERE name = ?", (name,)):
            return self._bytes(f"blob {name}", value)
        raise JournalError(f"{self._path} has no blob {name}: the journal is incomplete, restore it from a backup")

    def commits(self) -> Iterator[int]:
        """The last position of each commit, in order."""
        for (last,) in self._rows("SELECT last FROM commits ORDER BY rowid"):
            if not isinstance(last, int):
                raise self._damaged("its list of commits", f"{last!r} is no position")
            yield last

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Within it everything is read as of one commit, whatever another process adds meanwhile."""
        try:
            self._db.execute("BEGIN")
        except apsw.Error as error:
            raise self._damaged("its beginning", error) from error
        try:
            yield
        finally:
            if self._db.in_transaction:
                self._db.execute("ROLLBACK")

    def _rows(self, query: str, values: SQLiteValues = ()) -> list[_Row]:
        try:
            return self._db.execute(query, values).fetchall()
        except (apsw.Error, UnicodeDecodeError) as error:
            raise self._damaged("a table beside its lines", error) from error

    def _line(self, row: _Row) -> Line:
        position, at_ns, record = row
        if not isinstance(position, int) or not isinstance(at_ns, int) or not isinstance(record, bytes):
            raise self._damaged(f"line {position}", "its columns hold what no journal writes")
        try:
            # The whole of it must be text: what is carried as raw JSON is not looked into here, but later.
            return Line(position, at_ns, self._decode(record.decode()))
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise self._damaged(f"line {position}", error) from error

    def _bytes(self, what: str, value: SQLiteValue) -> bytes:
        if not isinstance(value, bytes):
            raise self._damaged(what, "it is no content of bytes")
        return value

    def _damaged(self, what: str, why: Exception | str) -> JournalError:
        return JournalError(
            f"{self._path} is damaged: {what} cannot be read ({why}); "
            "restore the file from a backup, or begin a new journal with --journal"
        )
