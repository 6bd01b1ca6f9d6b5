"""The journal's SQLite schema. A version, once released, never changes; ``migration.py`` takes an older file to this one.

Version 1 (0.1) held one line of JSON a row. Version 2 holds the entries of a commit a row, in few bytes (docs/journal.md).
"""

from __future__ import annotations

#: Written into the file's header, so that ``file`` and we ourselves know a journal from any other database.
APPLICATION_ID = 0x57414B45  # "WAKE"

VERSION = 2

#: Must be set before the first table is made: freed pages go back to the disk, a few at a time.
BEFORE = "PRAGMA auto_vacuum=INCREMENTAL"

SCHEMA = """
    CREATE TABLE rows(
        first INTEGER PRIMARY KEY,
        last INTEGER NOT NULL,
        at_ns INTEGER NOT NULL,
        form INTEGER NOT NULL,
        digest BLOB NOT NULL,
        body BLOB NOT NULL
    ) STRICT;
    CREATE TABLE about(
        first INTEGER PRIMARY KEY,
        admitted INTEGER NOT NULL,
        duplicate INTEGER NOT NULL,
        refused INTEGER NOT NULL,
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
    CREATE VIEW conservation AS
        SELECT sum(admitted + duplicate + refused) AS received,
               sum(admitted) AS admitted,
               sum(duplicate) AS duplicate,
               sum(refused) AS refused
        FROM about;
"""
