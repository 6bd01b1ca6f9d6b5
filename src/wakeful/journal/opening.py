"""Opening a journal's file: who may read it, what it is, and in which schema."""

from __future__ import annotations

import os
from pathlib import Path

import apsw

from wakeful.contracts.journal import JournalError
from wakeful.facts.crash_points import reach
from wakeful.journal.schema import APPLICATION_ID, BEFORE, SCHEMA, VERSION

#: The write-ahead file is cut to this size whenever it begins anew.
_WAL_BYTES = 8_000_000


def prepare(path: Path) -> None:
    """Make the file and its directory where they are absent, for their owner alone, and see that it can be written.

    Raises:
        JournalError: it cannot be.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if path.exists():
            os.close(os.open(path, os.O_RDWR))
        else:
            os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
            sync_directory(path.parent)
    except OSError as error:
        raise JournalError(
            f"{path} cannot be written: {error.strerror}; name another file with --journal or free the place"
        ) from error


def connect(path: Path, *, read_only: bool, full_sync: bool, vfs: str | None) -> apsw.Connection:
    """A connection to the journal at ``path``, in today's schema.

    Raises:
        JournalError: it is another database, of a newer schema, or of an older one and only to be read.
        apsw.Error: SQLite cannot open it.
    """
    flags = apsw.SQLITE_OPEN_READONLY if read_only else apsw.SQLITE_OPEN_READWRITE
    db = apsw.Connection(str(path), flags=flags, vfs=vfs)
    db.set_busy_timeout(5_000)
    tables = number(db, "SELECT count(*) FROM sqlite_schema")
    version = version_of(db, path)
    if read_only:
        if not tables:
            raise JournalError(f"{path} is empty; fill it with `wakeful run --journal {path} SOURCE`")
        if version < VERSION:
            raise JournalError(
                f"{path} has the older schema {version}; bring it to {VERSION} with `wakeful compact --journal {path}`, which "
                "keeps a backup beside it"
            )
        return db
    if not tables:
        db.execute(BEFORE)
    db.execute("PRAGMA journal_mode=WAL")
    db.execute(f"PRAGMA synchronous={'FULL' if full_sync else 'NORMAL'}")
    db.execute(f"PRAGMA journal_size_limit={_WAL_BYTES}")
    if not tables:
        with db:
            write_schema(db)
    return db


def version_of(db: apsw.Connection, path: Path) -> int:
    """The schema of a journal; 0 for an empty file.

    Raises:
        JournalError: it is no journal, or one of a newer schema.
    """
    version = number(db, "PRAGMA user_version")
    if number(db, "PRAGMA application_id") != APPLICATION_ID and number(db, "SELECT count(*) FROM sqlite_schema"):
        raise JournalError(f"{path} is a database, but not a wakeful journal; name another file with --journal")
    if version > VERSION:
        raise JournalError(f"{path} has schema {version}, this wakeful knows {VERSION}: install the newer wakeful that wrote it")
    return version


def write_schema(db: apsw.Connection) -> None:
    """Make the tables, within the caller's transaction."""
    db.execute(SCHEMA)
    reach("journal: schema written")
    db.execute(f"PRAGMA application_id={APPLICATION_ID}")
    db.execute(f"PRAGMA user_version={VERSION}")


def number(db: apsw.Connection, query: str) -> int:
    """The one number that a query gives."""
    return int(next(db.execute(query))[0])


def sync_directory(directory: Path) -> None:
    """Make the names in it durable: the journal's own name must outlive a loss of power as its content does."""
    handle = os.open(directory, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def boot_id() -> str:
    """Which start of the machine this is; empty where nobody says."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return ""
