"""The compactor: gives up what is older than the retention, in small transactions between the mind's own commits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import apsw
import msgspec
import numpy as np

from wakeful.contracts.journal import JournalError
from wakeful.facts.crash_points import reach
from wakeful.facts.packs import Entry
from wakeful.journal.compaction.ages import Ages
from wakeful.journal.compaction.owed import Owed
from wakeful.journal.compaction.sieve import Gap, Sieve, all_kept, sift
from wakeful.journal.packed.body import SQUEEZED, BodyWriter
from wakeful.journal.packed.row import VERSIONS, Counts, Row, rows_of
from wakeful.journal.retention import Retention
from wakeful.journal.schema import PRESENT

#: What is done in one step, a few milliseconds' work: so many rows are passed over or taken away, read, or pages given back.
_ROWS_PER_STEP = 128
_READ_PER_STEP = 6
_LINES_PER_STEP = 16_000
_PAGES_PER_STEP = 512
_KEYS_PER_STEP = 256


#: The highest process among the last rows before an id: they are numbered in the order in which they are created.
_HIGHEST = "SELECT coalesce(max(process), 0) FROM (SELECT process FROM about WHERE id < ? ORDER BY id DESC LIMIT 1000)"


class _Old(msgspec.Struct, frozen=True):
    id: int
    last: int
    at_ns: int
    counts: Counts
    keys: bytes

    @property
    def first(self) -> int:
        """The position of its first line."""
        return self.id // VERSIONS


class Compactor:
    """Works in steps; between two of them the journal is whole, and may be committed to or closed.

    Args:
        db: the journal's connection.
        retention: what is kept.
        read: gives the entries of the row with that first position.
        insert: puts rows, with the words that they need, within the transaction.
        writer: of bodies.
    """

    def __init__(
        self,
        db: apsw.Connection,
        retention: Retention,
        read: Callable[[int], list[Entry]],
        insert: Callable[[Sequence[Row]], None],
        writer: BodyWriter,
    ) -> None:
        self.rounds = 0
        self._db = db
        self._retention = retention
        self._read = read
        self._insert = insert
        self._writer = writer
        self._ages: Ages | None = None
        self._owed: Owed | None = None
        self._look = True
        self._swept = False
        self._steps: Iterator[None] | None = None
        self._committed_rows = 0
        # What was owed when it was compacted, and the events of that: none known before the first round.
        self._owed_then: set[int] = set()
        self._known: set[str] | None = None

    def committed(self, entries: Sequence[Entry], rows: Sequence[Row]) -> None:
        """Hear of what was committed."""
        self._committed_rows += len(rows)
        if self._ages is not None:
            for row in rows:
                self._look |= self._ages.add(row.last, row.at_ns, row.counts.admitted)
        if self._owed is not None:
            for entry in entries:
                self._owed.see(entry)

    def due(self) -> int:
        """How many steps to take now: one, or one for each row that was committed since this was asked last.

        A step reads several rows. So what there is to do grows more slowly than it is done, however much a commit brings.
        """
        steps, self._committed_rows = max(1, self._committed_rows), 0
        return steps

    def step(self, least_events: int = 0) -> bool:
        """Do a little of what there is to do.

        Args:
            least_events: so many events must be old enough for a round to begin; 0: as many as make it worth the while.

        Returns:
            whether there is more to do.

        Raises:
            apsw.Error: it could not be written; the journal is as it was before this step.
            JournalError: a row that must be read is damaged.
        """
        if self._steps is None:
            if not (self._look or least_events):
                return False
            self._look = False
            ages, used_bytes = self._known_ages(), self._used_bytes()
            boundary = ages.boundary(self._retention, used_bytes, least_events)
            if boundary:
                self._steps = self._round(boundary)
            elif self._owed is None and ages.half_full(self._retention, used_bytes):
                self._steps = self._catch_up()
            else:
                return False
        try:
            next(self._steps)
        except StopIteration:
            self._steps, self._look = None, True
        except (apsw.Error, JournalError):
            self._steps = None
            raise
        return True

    def _known_ages(self) -> Ages:
        if self._ages is None:
            self._ages = Ages()
            query = f"SELECT last, at_ns, admitted FROM about WHERE id > (SELECT position FROM frontier) * {VERSIONS} ORDER BY id"
            for last, at_ns, admitted in self._query(query):
                self._ages.add(last, at_ns, admitted)
        return self._ages

    def _query(self, query: str, *values: int) -> Iterator[tuple[Any, ...]]:
        """Rows of tables whose columns are STRICT: what comes is of the type that the schema says."""
        yield from self._db.execute(query, values)

    def _used_bytes(self) -> int:
        pages, free, size = (self._pragma(name) for name in ("page_count", "freelist_count", "page_size"))
        return (pages - free) * size

    def _pragma(self, name: str) -> int:
        value: int
        ((value,),) = self._query(f"PRAGMA {name}")
        return value

    def _round(self, boundary: int) -> Iterator[None]:
        """Give up what may be given up, up to a position."""
        if not self._swept:
            # Of a round that was broken off: what it would have replaced stays.
            self._db.execute("UPDATE about SET died = NULL WHERE died > (SELECT generation FROM frontier)")
            yield from self._sweep()
        self._swept = False
        if self._owed is None:
            yield from self._catch_up()
        owed = self._owed if self._owed is not None else Owed()
        processes = owed.processes()
        # What was compacted is looked at again only when half of it is owed no longer; else a round would last the longer the
        # more is owed, while more comes.
        again = self._known is None or 2 * len(self._owed_then - processes) > len(self._owed_then)
        ((before,),) = self._query("SELECT position FROM frontier")
        begin = 0 if again else before
        owed_now = set(processes)
        yield from self._astride(boundary, processes)
        sieve = Sieve(processes, owed.outcomes(boundary), owed.places(), set() if again or self._known is None else self._known)
        size = -1
        while size != sieve.size:
            size = sieve.size
            for olds in self._rows(begin, boundary, sieve):
                for old in olds:
                    if sieve.concerns(old.first, old.last, old.keys):
                        sieve.learn(self._read(old.id))
                yield
            sieve.seek()
        gap, standing = Gap(), 0
        for olds in self._rows(begin, boundary, sieve):
            standing = self._replace(olds, sieve, gap, standing)
            yield
        with self._db:
            reach("compaction: rows replaced")
            self._db.execute("UPDATE frontier SET position = ?, generation = generation + 1", (boundary,))
            self._db.execute("DELETE FROM commits WHERE last <= ?", (boundary,))
        reach("compaction: done")
        self._known_ages().given_up(boundary)
        owed.given_up(boundary)
        self._known = sieve.events
        self._owed_then = owed_now if again else self._owed_then | owed_now
        self.rounds += 1
        yield from self._sweep()

    def _sweep(self) -> Iterator[None]:
        """Take away what is not there in the present generation, and give its pages back to the disk."""
        ((generation,),) = self._query("SELECT generation FROM frontier")
        ((highest,),) = self._query("SELECT coalesce(max(id), 0) FROM about")
        id_ = 0
        query = "SELECT id, last, born, died FROM about WHERE id > ? AND id <= ? ORDER BY id LIMIT ?"
        while rows := list(self._query(query, id_, highest, _KEYS_PER_STEP)):
            gone: list[int] = []
            lines = 0
            for id_, last, born, died in rows:
                if born > generation or (died is not None and died <= generation):
                    gone.append(id_)
                    lines += last - id_ // VERSIONS + 1
                if lines > _LINES_PER_STEP:
                    break
            if gone:
                with self._db:
                    self._delete(gone)
            yield
        while self._pragma("freelist_count"):
            self._db.execute(f"PRAGMA incremental_vacuum({_PAGES_PER_STEP})").fetchall()
            yield
        self._swept = True

    def _delete(self, ids: Sequence[int]) -> None:
        for table in ("rows", "about"):
            self._db.execute(f"DELETE FROM {table} WHERE id IN ({','.join('?' * len(ids))})", ids)

    def _catch_up(self) -> Iterator[None]:
        """Follow what was committed before anybody listened, and meanwhile: it is read faster than more comes (see ``due``)."""
        owed, id_ = Owed(), 0
        query = f"SELECT id, last FROM about WHERE id > ? AND {PRESENT} ORDER BY id LIMIT ?"
        while rows := list(self._query(query, id_, _ROWS_PER_STEP)):
            lines = 0
            for id_, last in rows:
                for entry in self._read(id_):
                    owed.see(entry)
                lines += last - id_ // VERSIONS + 1
                if lines > _LINES_PER_STEP // 16:  # to read a line takes longer than to take it away
                    lines = 0
                    yield
        self._owed = owed

    def _astride(self, boundary: int, processes: set[int]) -> Iterator[None]:
        """Add the processes that were created before a position, and of which something is told after it."""
        ((highest,),) = self._query(_HIGHEST, (boundary + 1) * VERSIONS)
        # What is committed meanwhile is of other events: these are older than any that may still be told of.
        ((newest,),) = self._query("SELECT max(id) FROM about")
        position = boundary
        query = f"SELECT last, keys FROM about WHERE id > ? * {VERSIONS} AND id <= ? AND {PRESENT} ORDER BY id LIMIT ?"
        while rows := list(self._query(query, position, newest, _KEYS_PER_STEP)):
            # Keys of events may look like those of processes: then a process more is kept, until the next round.
            numbers = np.frombuffer(b"".join(keys for _, keys in rows), dtype=np.uint32)
            processes.update(numbers[numbers <= highest].tolist())
            position = rows[-1][0]
            yield

    def _rows(self, begin: int, boundary: int, sieve: Sieve) -> Iterator[list[_Old]]:
        """What the rows between two positions are about; so many at a time that only a few of them have to be read."""
        query = (
            "SELECT id, last, at_ns, admitted, duplicate, refused, gained, process, experience, keys FROM about "
            f"WHERE id > ? AND id < ? AND last <= ? AND {PRESENT} ORDER BY id LIMIT ?"
        )
        # Not by their last positions alone: then all younger rows would be looked through for more.
        id_, beyond = begin * VERSIONS + VERSIONS - 1, (boundary + 1) * VERSIONS
        while rows := list(self._query(query, id_, beyond, boundary, _ROWS_PER_STEP)):
            olds: list[_Old] = []
            read = 0
            for row in rows:
                olds.append(_Old(row[0], row[1], row[2], Counts(*row[3:9]), row[9]))
                read += sieve.concerns(olds[-1].first, olds[-1].last, olds[-1].keys)
                if read == _READ_PER_STEP:
                    break
            id_ = olds[-1].id
            yield olds

    def _replace(self, olds: list[_Old], sieve: Sieve, gap: Gap, standing: int) -> int:
        """Put what is kept of some rows, and the counts of the rest, beside them, for the next generation.

        Args:
            standing: the id of the row that stands for the open gap, 0 for none: it grows into these rows.

        Returns:
            the same for the next rows.
        """
        rows: list[Row] = []
        kept: list[Entry] = []
        gone: list[int] = []
        for old in olds:
            entries = self._read(old.id) if sieve.concerns(old.first, old.last, old.keys) else []
            if entries and all_kept(entries, sieve):
                # It stays where it is; what stood open before it is closed.
                if standing and not gone and not kept:
                    standing = 0
                    gap.close()
                elif gap.first:
                    kept.append(gap.close())
                rows.extend(rows_of(kept, self._writer, SQUEEZED))
                kept.clear()
                continue
            gone.append(old.id)
            if entries:
                kept.extend(sift(entries, sieve, gap))
            else:
                gap.add(old.first, old.last, old.at_ns, old.counts)
        rows.extend(rows_of(kept, self._writer, SQUEEZED))
        if not gone and not rows:
            return standing
        if gap.first:
            rows.extend(rows_of([gap.line()], self._writer))
        ((generation,),) = self._query("SELECT generation FROM frontier")
        with self._db:
            reach("compaction: begun")
            if standing:
                self._delete([standing])
            rows = [self._placed(row, generation + 1) for row in rows]
            self._insert(rows)
            marks = ",".join("?" * len(gone))
            self._db.execute(f"UPDATE about SET died = ? WHERE id IN ({marks})", (generation + 1, *gone))
        return rows[-1].id if gap.first else 0

    def _placed(self, row: Row, born: int) -> Row:
        """The row in a version of its place that is free."""
        taken = {id_ for (id_,) in self._query("SELECT id FROM about WHERE id BETWEEN ? AND ?", row.id, row.id + VERSIONS - 1)}
        version = next(each for each in range(VERSIONS) if row.id + each not in taken)
        return msgspec.structs.replace(row, version=version, born=born)
