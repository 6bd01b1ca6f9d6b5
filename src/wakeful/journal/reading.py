"""What a SQLite journal holds, read row by row: what cannot be read is named with its place, never a crash."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import apsw

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Line
from wakeful.facts.packs import Entry, expanded, last_position
from wakeful.journal.packed.body import BROKEN, BodyReader
from wakeful.journal.packed.row import VERSIONS, digest_of, event_key, kind_key, process_key
from wakeful.journal.packed.words import Words
from wakeful.journal.readable import event_of, process_of, tag_of
from wakeful.journal.schema import PRESENT

if TYPE_CHECKING:
    from apsw import SQLiteValue, SQLiteValues

_Row = tuple["SQLiteValue", ...]

_SELECT = "SELECT id, rows.last, form, digest, body FROM about JOIN rows USING (id)"


class Reading:
    """Reads the tables of one open journal. Every method raises JournalError where the file is damaged."""

    def __init__(self, db: apsw.Connection, path: Path) -> None:
        self._db = db
        self._path = path
        self.words = Words(self._words(), self._words)
        self._body = BodyReader(self.words)

    def entries(self, after: int) -> Iterator[Entry]:
        """The entries whose last position is greater, in order."""
        start = f"id >= coalesce((SELECT max(id) FROM about WHERE id < ? AND {PRESENT}), 0)"
        for entry in self._entries(f"{_SELECT} WHERE {start} AND {PRESENT} ORDER BY id", ((after + 2) * VERSIONS,)):
            if last_position(entry) > after:
                yield entry

    def lines(self, after: int) -> Iterator[Line]:
        """The lines with greater positions, in order."""
        return (line for line in expanded(self.entries(after)) if line.position > after)

    def lines_of(self, event: str | None, process: int | None, kinds: Sequence[str]) -> Iterator[Line]:
        """The lines about an event, about a process and of some kinds, in order: of those rows whose keys have them."""
        sought = [] if event is None else [[event_key(event)]]
        sought += [] if process is None else [[process_key(process)]]
        sought += [[kind_key(kind) for kind in kinds]] if kinds else []
        where = " AND ".join(f"({' OR '.join(['instr(keys, ?)'] * len(keys))})" for keys in sought)
        query = f"{_SELECT} WHERE {PRESENT} {'AND ' + where if where else ''} ORDER BY id"
        for line in expanded(self._entries(query, [key for keys in sought for key in keys])):
            record = line.record
            if event is not None and event_of(record) != event:
                continue
            if process is not None and process_of(record) != process:
                continue
            if not kinds or tag_of(record) in kinds:
                yield line

    def row(self, id_: int) -> list[Entry]:
        """The entries of one row."""
        return list(self._entries(f"{_SELECT} WHERE id = ?", (id_,)))

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
        for (last,) in self._rows("SELECT last FROM commits ORDER BY last"):
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

    def _entries(self, query: str, values: Sequence[int | bytes]) -> Iterator[Entry]:
        reached: SQLiteValue = 0
        try:
            for row in self._db.execute(query, values):
                reached = row[1]
                yield from self._row(row)
        except apsw.Error as error:
            raise self._damaged(f"what follows line {reached}", error) from error

    def _row(self, row: _Row) -> list[Entry]:
        id_, last, form, digest, body = row
        if not (isinstance(id_, int) and isinstance(last, int) and isinstance(form, int) and isinstance(body, bytes)):
            raise self._damaged(f"row {id_}", "its columns hold what no journal writes")
        first = id_ // VERSIONS
        where = f"line {first}" if first == last else f"the row of lines {first} to {last}"
        if digest != digest_of(first, body):
            raise self._damaged(where, "its content is not what was written")
        try:
            entries = list(self._body.read(first, body, form))
        except BROKEN as error:
            raise self._damaged(where, error) from error
        if not entries or last_position(entries[-1]) != last:
            raise self._damaged(where, "it holds other lines than it says")
        return entries

    def _words(self) -> list[tuple[int, str]]:
        found = []
        for number, text in self._rows("SELECT number, text FROM words ORDER BY number"):
            if not isinstance(number, int) or not isinstance(text, str):
                raise self._damaged("its table of words", f"{number!r} is no word")
            found.append((number, text))
        return found

    def _rows(self, query: str, values: SQLiteValues = ()) -> list[_Row]:
        try:
            return self._db.execute(query, values).fetchall()
        except (apsw.Error, UnicodeDecodeError) as error:
            raise self._damaged("a table beside its lines", error) from error

    def _bytes(self, what: str, value: SQLiteValue) -> bytes:
        if not isinstance(value, bytes):
            raise self._damaged(what, "it is no content of bytes")
        return value

    def _damaged(self, what: str, why: Exception | str) -> JournalError:
        return JournalError(
            f"{self._path} is damaged: {what} cannot be read ({why}); "
            "restore the file from a backup, or begin a new journal with --journal"
        )
