"""Journals as somebody with the file in his hands could change them: every row as the writer itself would have written it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import apsw

from wakeful.facts.lines import Line
from wakeful.journal import open_journal
from wakeful.journal.packed.body import BodyWriter
from wakeful.journal.packed.row import ABOUT_COLUMNS, ROWS_COLUMNS, VERSIONS, digest_of, rows_of
from wakeful.journal.packed.words import Words
from wakeful.journal.schema import PRESENT


def rewrite(path: Path, lines: Sequence[Line]) -> None:
    """Put these lines in the place of all that there are; nothing else is touched."""
    db = apsw.Connection(str(path))
    words = Words(db.execute("SELECT number, text FROM words").fetchall())
    with db:
        db.execute("DELETE FROM rows; DELETE FROM about")
        for row in rows_of(lines, BodyWriter(words)):
            db.execute(f"INSERT INTO rows VALUES ({','.join('?' * ROWS_COLUMNS)})", row.stored)
            db.execute(f"INSERT INTO about VALUES ({','.join('?' * ABOUT_COLUMNS)})", row.about)
        db.executemany("INSERT INTO words VALUES (?, ?)", words.new)
    db.close()


def lines_in(path: Path) -> list[Line]:
    """All lines of a journal."""
    with open_journal(path, read_only=True) as opened:
        return list(opened.lines())


def spoil(path: Path, position: int, body: bytes, *, sealed: bool) -> tuple[int, int]:
    """Put other bytes in the place of the body of the row in which a line stands; ``sealed``: with their right digest.

    Returns:
        the first and the last position of that row.
    """
    db = apsw.Connection(str(path))
    query = f"SELECT id, last FROM about WHERE id < ? AND {PRESENT} ORDER BY id DESC LIMIT 1"
    ((id_, last),) = db.execute(query, ((position + 1) * VERSIONS,)).fetchall()
    first = id_ // VERSIONS
    db.execute("UPDATE rows SET body = ? WHERE id = ?", (body, id_))
    if sealed:
        db.execute("UPDATE rows SET digest = ? WHERE id = ?", (digest_of(first, body), id_))
    db.close()
    return first, last
