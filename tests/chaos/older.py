"""A journal put back into schema 1, as wakeful 0.1 wrote it: a line of JSON a row."""

from __future__ import annotations

from pathlib import Path

import apsw
import msgspec

from wakeful.journal.schema import APPLICATION_ID
from wakeful.journal.sqlite import open_journal

_SCHEMA_1 = """
    CREATE TABLE lines(
        position INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, kind TEXT NOT NULL,
        event TEXT, process INTEGER, record TEXT NOT NULL
    ) STRICT;
    CREATE INDEX lines_by_event ON lines(event) WHERE event IS NOT NULL;
    CREATE INDEX lines_by_process ON lines(process) WHERE process IS NOT NULL;
    CREATE INDEX lines_by_kind ON lines(kind);
    CREATE TABLE state(key TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE blobs(name TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE commits(
        last INTEGER NOT NULL, wall_ns INTEGER NOT NULL, monotonic_ns INTEGER NOT NULL, boot TEXT NOT NULL
    ) STRICT;
"""


def put_back_to_schema_1(path: Path) -> None:
    """Write the journal at ``path`` anew in schema 1; it is closed, and holds the same lines, state, blobs and commits."""
    with open_journal(path) as journal:
        lines, state, commits = list(journal.lines()), journal.state(), list(journal.commits())
        names = [line.record.card.blob for line in lines if hasattr(line.record, "card") and line.record.card.accepted]
        blobs = {name: journal.blob(name) for name in names}
    for suffix in ("", "-wal", "-shm"):
        path.with_name(path.name + suffix).unlink(missing_ok=True)
    old = apsw.Connection(str(path))
    old.execute("PRAGMA journal_mode=WAL")
    with old:
        old.execute(_SCHEMA_1)
        old.execute(f"PRAGMA application_id={APPLICATION_ID}")
        old.execute("PRAGMA user_version=1")
        for line in lines:
            record = line.record
            event = getattr(record, "event", None)
            row = (
                line.position,
                line.at_ns,
                type(record).__name__.lower(),
                getattr(event, "id", event) or None,
                getattr(record, "process", None) or None,
                msgspec.json.encode(record).decode(),
            )
            old.execute("INSERT INTO lines VALUES (?, ?, ?, ?, ?, ?)", row)
        old.executemany("INSERT INTO state VALUES (?, ?)", state.items())
        old.executemany("INSERT INTO blobs VALUES (?, ?)", blobs.items())
        old.executemany("INSERT INTO commits VALUES (?, 0, 0, '')", [(last,) for last in commits])
    old.close()
