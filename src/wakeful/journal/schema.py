"""The journal's SQLite schema, as migrations from version 0. A migration, once released, never changes."""

from __future__ import annotations

#: Written into the file's header, so that ``file`` and we ourselves know a journal from any other database.
APPLICATION_ID = 0x57414B45  # "WAKE"

MIGRATIONS: tuple[str, ...] = (
    """
    CREATE TABLE lines(
        position INTEGER PRIMARY KEY,
        at_ns INTEGER NOT NULL,
        kind TEXT NOT NULL,
        event TEXT,
        process INTEGER,
        record TEXT NOT NULL
    ) STRICT;
    CREATE INDEX lines_by_event ON lines(event) WHERE event IS NOT NULL;
    CREATE INDEX lines_by_process ON lines(process) WHERE process IS NOT NULL;
    CREATE INDEX lines_by_kind ON lines(kind);
    CREATE TABLE state(key TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE blobs(name TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE commits(
        last INTEGER NOT NULL,
        wall_ns INTEGER NOT NULL,
        monotonic_ns INTEGER NOT NULL,
        boot TEXT NOT NULL
    ) STRICT;
    CREATE VIEW events AS
        SELECT position, at_ns, event AS id,
               json_extract(record, '$.event.kind') AS kind,
               json_extract(record, '$.event.entity') AS entity,
               json_extract(record, '$.event.says') AS says
        FROM lines WHERE kind = 'admitted';
    CREATE VIEW decisions AS
        SELECT position, at_ns, event, process,
               json_extract(record, '$.decision.treatment') AS treatment,
               json_extract(record, '$.decision.mode') AS mode,
               json_extract(record, '$.decision.confidence') AS confidence
        FROM lines WHERE kind = 'decided';
    CREATE VIEW conservation AS
        SELECT sum(kind IN ('admitted', 'duplicate', 'refused')) AS received,
               sum(kind = 'admitted') AS admitted,
               sum(kind = 'duplicate') AS duplicate,
               sum(kind = 'refused') AS refused
        FROM lines;
    """,
)

VERSION = len(MIGRATIONS)
