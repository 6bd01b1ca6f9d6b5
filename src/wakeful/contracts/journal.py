"""The contract of a journal: append-only lines, keyed state beside them, and blobs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from wakeful.facts.lines import Line
from wakeful.facts.packs import Entry


class JournalError(Exception):
    """The journal cannot be opened or written. The message says what is wrong, where, and what to do."""


class JournalStalled(JournalError):
    """It cannot be written for now (a full disk, one that fails). Nothing of the commit was kept; it may be tried again."""


class Journal(Protocol):
    """What the driver commits to, in one transaction: lines, keyed state, blobs.

    After ``commit`` returns the lines are durable. After it raised, none of them is there; after JournalStalled the same commit
    may be tried again.
    """

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """Append ``lines``, packed or not (positions must continue the journal's), replace ``state`` (None deletes) and add
        ``blobs``."""

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The lines with position > ``after``, in order; those of packs one by one."""

    def entries(self, after: int = 0) -> Iterator[Entry]:
        """What was committed with position > ``after``, in order, packs as packs where the journal keeps them: for recovery.

        ``after`` is the last position of an entry, or 0."""

    def state(self) -> dict[str, bytes]:
        """The keyed state as of the last commit."""

    def blob(self, name: str) -> bytes:
        """The bytes of a blob. Raises JournalError where there is none of that name."""

    @property
    def last(self) -> int:
        """The last position, 0 for an empty journal."""

    def tidy(self, least_events: int = 0) -> bool:
        """Do a little of its housekeeping, between two commits: nothing that is open or owed changes.

        ``least_events``: as soon as so many events are older than what is kept; 0: where it is worth the while. Returns whether
        there is more to do at once. Raises JournalError where it could not be done; all is as it was."""

    def close(self) -> None:
        """Release the file. Committed lines stay."""
