"""The journal's SQLite schema. A version, once released, never changes; ``migration.py`` takes an older file to this one.

Version 1 (0.1) held one line of JSON a row. Version 2 holds the entries of a commit a row, in few bytes (docs/journal.md).
"""

from __future__ import annotations

#: Written into the file's header, so that ``file`` and we ourselves know a journal from any other database.
APPLICATION_ID = 0x57414B45  # "WAKE"

VERSION = 2

#: Must be set before the first table is made: freed pages go back to the disk, a few at a time.
BEFORE = "PRAGMA auto_vacuum=INCREMENTAL"

#: What holds of a row that is to be read: it is there in the journal's present generation. Compaction puts new rows beside the
#: old ones, some at a time, and makes them the journal's by counting up the generation.
PRESENT = "born <= (SELECT generation FROM frontier) AND (died IS NULL OR died > (SELECT generation FROM frontier))"

SCHEMA = f"""
    CREATE TABLE rows(
        id INTEGER PRIMARY KEY,
        last INTEGER NOT NULL,
        form INTEGER NOT NULL,
        digest BLOB NOT NULL,
        body BLOB NOT NULL
    ) STRICT;
    CREATE TABLE about(
        id INTEGER PRIMARY KEY,
        last INTEGER NOT NULL,
        at_ns INTEGER NOT NULL,
        admitted INTEGER NOT NULL,
        duplicate INTEGER NOT NULL,
        refused INTEGER NOT NULL,
        gained INTEGER NOT NULL,
        process INTEGER NOT NULL,
        experience INTEGER NOT NULL,
        born INTEGER NOT NULL,
        died INTEGER,
        keys BLOB NOT NULL
    ) STRICT;
    CREATE TABLE words(number INTEGER PRIMARY KEY, text TEXT NOT NULL) STRICT;
    CREATE TABLE state(key TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE blobs(name TEXT PRIMARY KEY, value BLOB NOT NULL) STRICT, WITHOUT ROWID;
    CREATE TABLE commits(
        last INTEGER PRIMARY KEY,
        wall_ns INTEGER NOT NULL,
        monotonic_ns INTEGER NOT NULL,
        boot INTEGER NOT NULL
    ) STRICT;
    CREATE TABLE frontier(position INTEGER NOT NULL, generation INTEGER NOT NULL) STRICT;
    INSERT INTO frontier VALUES (0, 0);
    CREATE VIEW conservation AS
        SELECT coalesce(sum(admitted + duplicate + refused), 0) AS received,
               coalesce(sum(admitted), 0) AS admitted,
               coalesce(sum(duplicate), 0) AS duplicate,
               coalesce(sum(refused), 0) AS refused
        FROM about WHERE {PRESENT};
"""
