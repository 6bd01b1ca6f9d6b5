"""A copy of a journal as of one commit, made beside whoever writes it."""

from __future__ import annotations

import os
from pathlib import Path

import apsw

from wakeful.contracts.journal import JournalError
from wakeful.journal.opening import sync_directory

_PAGES = 1_000


def back_up(path: Path, to: Path) -> None:
    """Copy the journal at ``path`` to a new file that only its owner may read. The copy is there whole, or not at all.

    Raises:
        JournalError: there is something at ``to``, or the copy could not be written, or differs.
    """
    if to.exists():
        raise JournalError(f"{to} exists; name a file that does not")
    copying = to.with_name(to.name + ".partial")
    copying.unlink(missing_ok=True)
    try:
        os.close(os.open(copying, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        _copy(path, copying)
        os.replace(copying, to)
        sync_directory(to.parent)
    except (OSError, apsw.Error) as error:
        raise JournalError(f"{path} could not be copied to {to}: {error}") from error
    finally:
        copying.unlink(missing_ok=True)


def _copy(path: Path, to: Path) -> None:
    source = apsw.Connection(str(path), flags=apsw.SQLITE_OPEN_READONLY)
    copy = apsw.Connection(str(to))
    try:
        # Within one transaction the source stays as it is, whatever is written meanwhile.
        source.execute("BEGIN")
        count = source.execute("SELECT count(*), coalesce(max(last), 0) FROM about").fetchall()
        with copy.backup("main", source, "main") as backing:
            while not backing.done:
                backing.step(_PAGES)
        source.execute("COMMIT")
        if copy.execute("SELECT count(*), coalesce(max(last), 0) FROM about").fetchall() != count:
            raise JournalError(f"{path} could not be copied to {to}: the copy holds other rows")
        if copy.execute("PRAGMA integrity_check").fetchall() != [("ok",)]:
            raise JournalError(f"{path} could not be copied to {to}: the copy is not sound")
    finally:
        copy.close()
        source.close()
