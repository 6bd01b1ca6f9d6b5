"""From schema 1 to schema 2: the same journal, a backup beside it, and one of the two whenever the process is killed."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import apsw
import msgspec
import pytest

import wakeful
from tests.journal.builder import Book, full_book
from wakeful.contracts.journal import JournalError
from wakeful.facts.crash_points import CRASH_AT, CRASH_POINTS
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.readable import event_of, process_of, tag_of

#: Schema 1 as wakeful 0.1 wrote it; of its views one, which a migration must not stumble over.
SCHEMA_1 = """
    CREATE TABLE lines(
        position INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, kind TEXT NOT NULL,
        event TEXT, process INTEGER, record TEXT NOT NULL
    ) STRICT;
    CREATE INDEX lines_by_event ON lines(event) WHERE event IS NOT NULL;
    CREATE TABLE state(key TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE blobs(name TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE commits(
        last INTEGER NOT NULL, wall_ns INTEGER NOT NULL, monotonic_ns INTEGER NOT NULL, boot TEXT NOT NULL
    ) STRICT;
    CREATE VIEW conservation AS SELECT sum(kind = 'admitted') AS admitted FROM lines;
    PRAGMA application_id=1463896901;
    PRAGMA user_version=1;
"""


def old_journal(path: Path, book: Book) -> None:
    """The file that wakeful 0.1 would have written."""
    os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
    db = apsw.Connection(str(path))
    db.execute("PRAGMA journal_mode=WAL")
    db.execute(SCHEMA_1)
    encode = msgspec.json.Encoder().encode
    with db:
        for line in book.written:
            record = line.record
            row = (line.position, line.at_ns, tag_of(record), event_of(record) or None, process_of(record) or None)
            db.execute("INSERT INTO lines VALUES (?,?,?,?,?,?)", (*row, encode(record).decode()))
        for last in (5, len(book.written)):
            db.execute("INSERT INTO commits VALUES (?,?,?,?)", (last, 10 * last, last, "a boot"))
        db.execute("INSERT INTO state VALUES ('shelf', ?)", (b"{}",))
        db.executemany("INSERT INTO blobs VALUES (?, ?)", book.blobs.items())
    db.close()


@pytest.fixture
def book() -> Book:
    return full_book()


@pytest.fixture
def old(tmp_path: Path, book: Book) -> Path:
    path = tmp_path / "mind.db"
    old_journal(path, book)
    return path


def backup_of(path: Path) -> Path:
    return path.with_name(path.name + ".schema-1.backup")


def test_the_same_journal_stands_there_in_the_new_schema(old: Path, book: Book) -> None:
    with open_journal(old) as journal:
        assert journal.migrated is not None
        assert (journal.migrated.version, journal.migrated.lines) == (1, len(book.written))
        assert list(journal.lines()) == book.written
        assert journal.state() == {"shelf": b"{}"}
        assert {name: journal.blob(name) for name in book.blobs} == book.blobs
        assert list(journal.commits()) == [5, len(book.written)]
        report = audit(journal)
        assert report.ok or report.first_offender is None
        journal.commit([msgspec.structs.replace(book.written[-1], position=journal.last + 1)], {}, {})
    with open_journal(old) as journal:
        assert journal.migrated is None
        assert journal.last == len(book.written) + 1


def test_the_backup_is_the_file_as_it_was_for_its_owner_alone(old: Path, book: Book) -> None:
    open_journal(old).close()
    backup = backup_of(old)
    db = apsw.Connection(str(backup), flags=apsw.SQLITE_OPEN_READONLY)
    assert db.execute("SELECT count(*) FROM lines").fetchall() == [(len(book.written),)]
    assert db.execute("PRAGMA user_version").fetchall() == [(1,)]
    db.close()
    for file in old.parent.iterdir():
        assert stat.S_IMODE(file.stat().st_mode) == 0o600, file
    assert not list(old.parent.glob("*.partial*"))


@pytest.mark.parametrize("place", [name for name in CRASH_POINTS if name.startswith("migration:")])
def test_killed_in_the_middle_it_is_the_old_one_or_the_new_one(old: Path, book: Book, place: str) -> None:
    code = "import sys, pathlib; from wakeful.journal import open_journal; open_journal(pathlib.Path(sys.argv[1]))"
    environment = os.environ | {CRASH_AT: place, "PYTHONPATH": str(Path(wakeful.__file__).parents[1])}
    killed = subprocess.run([sys.executable, "-c", code, str(old)], env=environment, capture_output=True, check=False)
    assert killed.returncode == -signal.SIGKILL
    db = apsw.Connection(str(old), flags=apsw.SQLITE_OPEN_READONLY)
    ((version,),) = db.execute("PRAGMA user_version").fetchall()
    db.close()
    assert version == (2 if place == "migration: done" else 1)
    with open_journal(old) as journal:
        assert list(journal.lines()) == book.written
    assert backup_of(old).exists()
    assert not list(old.parent.glob("*.partial*"))


def test_a_damaged_line_leaves_the_file_as_it_was(old: Path) -> None:
    db = apsw.Connection(str(old))
    db.execute("UPDATE lines SET record = '{' WHERE position = 7")
    db.close()
    with pytest.raises(JournalError, match=r"line 7 cannot be read .* it is as it was"):
        open_journal(old)
    db = apsw.Connection(str(old), flags=apsw.SQLITE_OPEN_READONLY)
    assert db.execute("PRAGMA user_version").fetchall() == [(1,)]
    db.close()
    assert not list(old.parent.glob("*.partial*"))


def test_while_somebody_reads_it_nothing_is_migrated(old: Path) -> None:
    reader = apsw.Connection(str(old))
    reader.execute("BEGIN")
    assert reader.execute("SELECT count(*) FROM lines").fetchall()
    with pytest.raises(JournalError, match="somebody reads it: end that first"):
        open_journal(old)
    reader.close()
    open_journal(old).close()


def test_who_only_looks_is_told_how_to_bring_it_to_the_new_schema(old: Path) -> None:
    with pytest.raises(JournalError, match="wakeful compact --journal"):
        open_journal(old, read_only=True)
