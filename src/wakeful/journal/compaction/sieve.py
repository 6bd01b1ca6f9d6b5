"""The sieve: which lines of old rows are kept, and the counts that stand for the others."""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Iterable, Iterator
from typing import get_args

import msgspec

from wakeful.facts.lines import (
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Compacted,
    Concluded,
    Created,
    Decided,
    Duplicate,
    Gained,
    Judged,
    Line,
    Moved,
    Noted,
    Refused,
    Reopened,
    Trusted,
    Witnessed,
)
from wakeful.facts.packs import Covered, Entry, Inquired, Pack, Ran, Validated, Woken, last_position
from wakeful.journal.packed.row import Counts, count, count_burst, first_position, kind_key
from wakeful.journal.readable import event_of, process_of

#: What is told of events and their processes, and may be given up with them. Every other kind of record is kept.
GIVEN_UP: tuple[type[msgspec.Struct], ...] = (
    Admitted,
    Duplicate,
    Refused,
    Created,
    Decided,
    Moved,
    Asked,
    Answered,
    Concluded,
    Witnessed,
    Judged,
    Gained,
    Trusted,
    Noted,
    Reopened,
    Compacted,
)
#: By these keys a row is known to hold a kind of record that is always kept.
_KEPT_KINDS = frozenset(array("I", kind_key(cls.__name__.lower()))[0] for cls in get_args(AnyRecord) if cls not in GIVEN_UP)


class Sieve:
    """Knows what is kept of the rows before a boundary.

    Args:
        processes: the processes whose lines are kept; their events are found among the lines themselves (``learn``).
        outcomes: the outcomes that are kept, beside those that judged these processes.
        places: positions of single lines that are kept.
        events: what is known of the events of such processes from before.
    """

    def __init__(self, processes: set[int], outcomes: set[str], places: frozenset[int], events: Iterable[str] = ()) -> None:
        self._processes = processes
        self._places = places
        self.events: set[str] = set(events)
        self._outcomes = outcomes
        self._sought: set[int] = set()
        self.seek()

    def seek(self) -> None:
        """Make up anew what rows are recognised by."""
        self._sought = {number & 0xFFFFFFFF for number in self._processes}
        self._sought.update(zlib.crc32(each.encode()) for each in (*self.events, *self._outcomes))
        self._sought |= _KEPT_KINDS

    @property
    def size(self) -> int:
        """How much is known to be kept; it grows while ``learn`` finds more."""
        return len(self._processes) + len(self.events) + len(self._outcomes)

    def concerns(self, first: int, last: int, keys: bytes) -> bool:
        """Whether a row may hold something that is kept. Else it need not be read."""
        return not self._sought.isdisjoint(array("I", keys)) or any(first <= place <= last for place in self._places)

    def learn(self, entries: Iterable[Entry]) -> None:
        """Find the events of the processes that are kept, all processes of these events, and the outcomes that judged them."""
        for entry in entries:
            said = entry.burst if isinstance(entry, Pack) else entry.record
            if isinstance(said, Covered):
                self._belongs(said.process, said.event.id)
            elif isinstance(said, Created | Concluded | Ran):
                self._belongs(said.process, said.event)
            elif isinstance(said, Validated):
                self._judges(said.judged)
            elif isinstance(said, Judged):
                self._judges(said)

    def _belongs(self, process: int, event: str) -> None:
        if process in self._processes:
            self.events.add(event)
        elif event in self.events:
            self._processes.add(process)

    def _judges(self, judged: Judged) -> None:
        if judged.process in self._processes and judged.outcome:
            self._outcomes.add(judged.outcome)

    def keeps_pack(self, pack: Pack) -> bool | None:
        """Whether a pack is kept as a whole, or given up as a whole; None: its lines must be looked at one by one."""
        burst = pack.burst
        if any(pack.position <= place <= pack.last for place in self._places):
            return None
        if isinstance(burst, Validated):
            own = burst.judged.process in self._processes
            return own if own or burst.outcome.id not in self._outcomes else None
        if isinstance(burst, Inquired):
            return burst.asked.process in self._processes
        if isinstance(burst, Woken):
            return burst.answered.process in self._processes
        return burst.process in self._processes

    def keeps(self, line: Line) -> bool:
        """Whether a line is kept."""
        record = line.record
        if not isinstance(record, GIVEN_UP) or line.position in self._places:
            return True
        if isinstance(record, Admitted):
            return record.event.id in self.events
        if isinstance(record, Witnessed):
            return record.outcome.id in self._outcomes
        if isinstance(record, Duplicate | Refused | Compacted | Trusted):
            return False
        process = process_of(record)
        return process in self._processes if process else event_of(record) in self.events


class Gap:
    """Lines that follow one another and are given up: what is to be said of them in the end."""

    def __init__(self) -> None:
        self.first = 0
        self._last = 0
        self._at_ns = 0
        self._counts = Counts()

    def add(self, first: int, last: int, at_ns: int, counts: Counts) -> None:
        """More lines, right after the last ones."""
        self.first = self.first or first
        self._last, self._at_ns = last, at_ns
        for name in ("admitted", "duplicate", "refused", "gained"):
            setattr(self._counts, name, getattr(self._counts, name) + getattr(counts, name))
        for name in ("process", "experience"):
            setattr(self._counts, name, max(getattr(self._counts, name), getattr(counts, name)))

    def line(self) -> Line:
        """The line that stands for them as far as they go."""
        own = msgspec.structs.asdict(self._counts)
        return Line(self._last, self._at_ns, Compacted(first=self.first, lines=self._last - self.first + 1, **own))

    def close(self) -> Line:
        """The line that stands for them; the gap is empty again."""
        line = self.line()
        self.first, self._counts = 0, Counts()
        return line


def sift(entries: Iterable[Entry], sieve: Sieve, gap: Gap) -> Iterator[Entry]:
    """The entries that are kept, and the lines that stand for what was given up between them; the last gap stays open."""
    for entry in entries:
        whole = sieve.keeps_pack(entry) if isinstance(entry, Pack) else sieve.keeps(entry)
        if whole:
            if gap.first:
                yield gap.close()
            yield entry
        elif isinstance(entry, Pack) and whole is None:
            yield from sift(entry.lines(), sieve, gap)
        else:
            counts = Counts()
            if isinstance(entry, Pack):
                count_burst(entry.burst, counts)
            else:
                count(entry.record, counts, set())
            gap.add(first_position(entry), last_position(entry), entry.at_ns, counts)


def all_kept(entries: Iterable[Entry], sieve: Sieve) -> bool:
    """Whether every entry is kept as it is."""
    return all(sieve.keeps_pack(each) if isinstance(each, Pack) else sieve.keeps(each) for each in entries)
