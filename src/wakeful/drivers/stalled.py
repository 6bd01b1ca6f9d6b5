"""A journal that cannot be written for now: what goes on meanwhile, what is refused, and what is told of it afterwards."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import msgspec

from wakeful.contracts.journal import JournalStalled
from wakeful.facts.events import Undecodable
from wakeful.facts.inputs import Mark

_LOG = logging.getLogger("wakeful.journal")

#: How often writing is tried again.
RETRY_S = 1.0

#: So many entries wait in memory at most for the journal to take them; then treatments stand still too.
HELD_ENTRIES = 10_000

#: So many refusals wait in memory at most to be recorded; whoever offers more keeps what he has.
HELD_REFUSALS = 10_000

_MARK_BYTES = 64


class Broken(msgspec.Struct, frozen=True):
    """A run ended while its journal could not be written: since when, and how many offers it had refused by then."""

    since_ns: int
    refused: int


class StallMark:
    """A file beside the journal that can be written on a full disk too: its bytes are there from the start.

    Args:
        journal: the journal's file.
    """

    def __init__(self, journal: Path) -> None:
        self._path = journal.with_name(journal.name + ".stall")
        self.before: Broken | None = None
        if self._path.exists():
            self.before = _read(self._path.read_bytes())
        self._file = os.open(self._path, os.O_CREAT | os.O_RDWR, 0o600)
        self.write(None)

    def write(self, broken: Broken | None) -> None:
        """Say how it stands; None: the journal is written."""
        content = b"" if broken is None else f"{broken.since_ns} {broken.refused}".encode()
        try:
            os.pwrite(self._file, content.ljust(_MARK_BYTES), 0)
        except OSError as error:
            _LOG.warning("%s could not be written: %s; a crash before all is well will not be told of", self._path, error)

    def close(self) -> None:
        """The run ends with a journal that is written."""
        os.close(self._file)
        self._path.unlink(missing_ok=True)


class Stall:
    """Knows whether the journal can be written, and counts what is refused while it can't.

    Args:
        source: under whose name events are offered.
        clock_ns: kernel time.
        mark: outlives a crash; None for a journal without a file.
    """

    def __init__(self, source: str, clock_ns: Callable[[], int], mark: StallMark | None) -> None:
        self._source = source
        self._clock_ns = clock_ns
        self._mark = mark
        self._since_ns: int | None = None
        self._reason = ""
        self._refused: list[Undecodable | Mark] = []
        self._turned_away = 0

    @property
    def active(self) -> bool:
        """Whether nothing can be written now."""
        return self._since_ns is not None

    def begin(self, why: str) -> None:
        """Writing failed. Said once, however often it fails."""
        if self._since_ns is not None:
            return
        self._since_ns, self._reason = self._clock_ns(), f"the journal cannot be written: {why}"
        self._marked()
        _LOG.error("%s; treatments work on, but nothing is called, acknowledged or admitted until it can be written again", why)

    def refuse(self, position: int, kind: str) -> str:
        """An event was offered meanwhile. Returns the reason for which it is refused; it is recorded once that can be."""
        self._refused.append(Undecodable(source=self._source, position=position, reason=self._reason, excerpt=kind[:80]))
        self._refused.append(Mark(source=self._source, position=position))
        self._marked()
        return self._reason

    def turn_away(self, count: int) -> NoReturn:
        """So much was offered meanwhile that has no receipt, or for whose refusals there is no room: its owner keeps it.

        Raises:
            JournalStalled: always.
        """
        self._turned_away += count
        raise JournalStalled(f"{self._reason}; nothing of this was taken, hand it over again later")

    def has_room(self, count: int) -> bool:
        """Whether so many refusals more may wait to be recorded."""
        return len(self._refused) // 2 + count <= HELD_REFUSALS

    def over(self) -> list[Undecodable | Mark]:
        """It was written. Returns what is to be fed: the refusals of the meantime, which are to be recorded now."""
        if self._since_ns is None:
            return []
        seconds = (self._clock_ns() - self._since_ns) / 1e9
        _LOG.warning(
            "the journal is written again, after %.0f s; %d offers were refused, %d turned away without a record",
            seconds,
            len(self._refused) // 2,
            self._turned_away,
        )
        refused, self._refused, self._since_ns, self._turned_away = self._refused, [], None, 0
        self._marked()
        return refused

    def close(self) -> None:
        """The driver ends. Where nothing can be written the mark stays, for the next run to tell of it."""
        if self._mark is not None and not self.active:
            self._mark.close()

    def _marked(self) -> None:
        if self._mark is not None:
            broken = None if self._since_ns is None else Broken(self._since_ns, len(self._refused) // 2)
            self._mark.write(broken)


def _read(content: bytes) -> Broken | None:
    parts = content.split()
    if len(parts) != 2 or not all(part.isdigit() for part in parts):
        return None
    return Broken(int(parts[0]), int(parts[1]))
