"""A journal that is read once and then followed, beside whoever writes it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import TypeVar

from wakeful.contracts.journal import JournalError
from wakeful.journal.sqlite import SqliteJournal, open_journal
from wakeful.journal.views import History

T = TypeVar("T")


class Followed:
    """The history of a journal, brought up to its last line at each look. May be used from several threads.

    Args:
        path: the journal; it is opened for reading only and read whole, once.

    Raises:
        JournalError: there is no journal, or it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = Lock()
        self._open()
        self.look(lambda _journal, read: read.last)

    def _open(self) -> None:
        self._journal = open_journal(self.path, read_only=True)
        self._file = _identity(self.path)
        self._read = History()

    def look(self, view: Callable[[SqliteJournal, History], T]) -> T:
        """Take up what was committed since, then let ``view`` look. It blocks: call it from a thread of its own.

        Raises:
            JournalError: the file has gone or cannot be read any more. The next look tries again.
        """
        with self._lock:
            # A run may have begun again with a new file under the old name.
            if _identity(self.path) != self._file:
                self._journal.close()
                self._file = None
                self._open()
            for line in self._journal.lines(after=self._read.last):
                self._read.take(line)
            return view(self._journal, self._read)

    def written_s(self) -> float:
        """When the journal was last written, in seconds of Unix time; 0 where it has gone."""
        found = 0.0
        for path in (self.path, self.path.with_name(self.path.name + "-wal")):
            try:
                found = max(found, path.stat().st_mtime)
            except FileNotFoundError:
                continue
        return found

    def close(self) -> None:
        """Release the file."""
        with self._lock:
            self._journal.close()


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        found = os.stat(path)
    except FileNotFoundError:
        raise JournalError(f"the journal {path} has gone; it is looked for again at each change") from None
    return found.st_dev, found.st_ino
