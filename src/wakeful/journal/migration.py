"""From an older schema to today's: a verified backup beside the file, a new file beside both, and one rename.

Killed at any instant, the file is either the old journal or the new one, whole; the next start begins the migration again.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import apsw
import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.facts.crash_points import reach
from wakeful.facts.lines import AnyRecord, Line
from wakeful.journal.opening import number, sync_directory, version_of, write_schema
from wakeful.journal.packed.body import BodyWriter
from wakeful.journal.packed.row import ABOUT_COLUMNS, ENTRIES_PER_ROW, ROWS_COLUMNS, Row, rows_of
from wakeful.journal.packed.words import Words
from wakeful.journal.reading import Reading
from wakeful.journal.schema import BEFORE, VERSION

_COPIED_PAGES = 1_000


class Migrated(msgspec.Struct, frozen=True):
    """What a migration did: from which schema, how many lines, and where the file as it was lies."""

    version: int
    lines: int
    backup: Path


def migrate(path: Path) -> Migrated | None:
    """Bring the journal at ``path`` to today's schema, if it has an older one. The caller holds its lock.

    Returns:
        what was done; None where there was nothing to do.

    Raises:
        JournalError: it is damaged, somebody is reading it, or there is no room; it is as it was.
    """
    partial = path.with_name(f"{path.name}.schema-{VERSION}.partial")
    _remove(partial)
    if not path.stat().st_size:
        return None
    old = apsw.Connection(str(path), flags=apsw.SQLITE_OPEN_READWRITE)
    finished = False
    try:
        old.set_busy_timeout(5_000)
        version = version_of(old, path)
        if version in (0, VERSION):
            return None
        # No other connection may be there, and nothing may stay behind in a write-ahead file: a new one would take it up.
        if not _alone(old):
            raise JournalError(f"{path} must be brought to schema {VERSION}, but somebody reads it: end that first")
        backup = _backed_up(old, path, version)
        reach("migration: backed up")
        lines = _rewrite(old, partial, path)
        reach("migration: rewritten")
        finished = True
    except apsw.Error as error:
        raise JournalError(f"{path} could not be brought to schema {VERSION}: {error}; it is as it was") from error
    finally:
        old.close()
        if not finished:
            _remove(partial)
    os.replace(partial, path)
    sync_directory(path.parent)
    reach("migration: done")
    return Migrated(version, lines, backup)


def _alone(old: apsw.Connection) -> bool:
    """Take the file for this connection alone, without a write-ahead file; False: another has it open."""
    try:
        ((mode,),) = old.execute("PRAGMA journal_mode=DELETE").fetchall()
        old.execute("PRAGMA locking_mode=EXCLUSIVE").fetchall()
        old.execute("BEGIN EXCLUSIVE; COMMIT")
    except apsw.BusyError:
        return False
    return mode == "delete"


def _backed_up(old: apsw.Connection, path: Path, version: int) -> Path:
    """A copy of the file as it is, under a name of its own, compared with it line by line."""
    backup = path.with_name(f"{path.name}.schema-{version}.backup")
    copying = backup.with_name(backup.name + ".partial")
    _remove(copying)
    os.close(os.open(copying, os.O_CREAT | os.O_RDWR, 0o600))
    copy = apsw.Connection(str(copying))
    try:
        with copy.backup("main", old, "main") as backing:
            while not backing.done:
                backing.step(_COPIED_PAGES)
        if number(copy, "SELECT count(*) FROM lines") != number(old, "SELECT count(*) FROM lines") or next(
            copy.execute("PRAGMA integrity_check")
        ) != ("ok",):
            raise JournalError(f"{path} could not be copied to {backup}: the copy differs; it is as it was")
    finally:
        copy.close()
    os.replace(copying, backup)
    sync_directory(path.parent)
    return backup


def _rewrite(old: apsw.Connection, partial: Path, path: Path) -> int:
    """The same journal in a new file, in today's schema, read again and compared; returns its lines."""
    os.close(os.open(partial, os.O_CREAT | os.O_RDWR, 0o600))
    new = apsw.Connection(str(partial))
    try:
        new.execute(BEFORE)
        with new:
            write_schema(new)
            words = Words()
            writer = BodyWriter(words)
            for group in _groups(_lines(old, path)):
                for row in rows_of(group, writer):
                    _insert(new, row)
            for last, wall_ns, monotonic_ns, boot in old.execute("SELECT last, wall_ns, monotonic_ns, boot FROM commits"):
                named = int.from_bytes(words.constant(str(boot)), "big")
                new.execute("INSERT OR IGNORE INTO commits VALUES (?, ?, ?, ?)", (last, wall_ns, monotonic_ns, named))
            new.executemany("INSERT INTO words VALUES (?, ?)", words.new)
            new.executemany("INSERT INTO state VALUES (?, ?)", old.execute("SELECT key, value FROM state"))
            new.executemany("INSERT INTO blobs VALUES (?, ?)", old.execute("SELECT name, value FROM blobs"))
        count = 0
        for count, (before, after) in enumerate(zip(_lines(old, path), Reading(new, partial).lines(0), strict=True), 1):
            if before != after:
                raise JournalError(f"{path} could not be brought to schema {VERSION}: line {count} differs; it is as it was")
    except ValueError as error:
        raise JournalError(f"{path} could not be brought to schema {VERSION}: {error}; it is as it was") from error
    finally:
        new.close()
    return count


def _lines(old: apsw.Connection, path: Path) -> Iterator[Line]:
    decode = msgspec.json.Decoder(AnyRecord).decode
    for position, at_ns, record in old.execute("SELECT position, at_ns, CAST(record AS BLOB) FROM lines ORDER BY position"):
        try:
            yield Line(position, at_ns, decode(record))
        except msgspec.DecodeError as error:
            raise JournalError(f"{path} is damaged: line {position} cannot be read ({error}); it is as it was") from error


def _groups(lines: Iterator[Line]) -> Iterator[list[Line]]:
    group: list[Line] = []
    for line in lines:
        group.append(line)
        if len(group) == ENTRIES_PER_ROW:
            yield group
            group = []
    if group:
        yield group


def _insert(new: apsw.Connection, row: Row) -> None:
    new.execute(f"INSERT INTO rows VALUES ({','.join('?' * ROWS_COLUMNS)})", row.stored)
    new.execute(f"INSERT INTO about VALUES ({','.join('?' * ABOUT_COLUMNS)})", row.about)


def _remove(path: Path) -> None:
    for suffix in ("", "-journal", "-wal", "-shm"):
        path.with_name(path.name + suffix).unlink(missing_ok=True)
