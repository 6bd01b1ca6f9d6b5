"""The ledger of forecasts: what each result said the world would show, until when, and what came of it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush

import msgspec

from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.validation.timeline import Timeline

ANY = "*"
"""An entity that stands for the whole robot."""


class Entry(msgspec.Struct, kw_only=True):
    """One result's forecast. ``since_ns`` and ``until_ns`` bound its window, (since, until], by kernel time.

    ``shown`` is the label of the verdict that stands,
    ``decided_by`` its outcome's id, empty where the window closed or the recording ended; ``decided_ns`` its time, None likewise.
    """

    process: int
    event: str
    treatment: str
    mode: str
    label: str
    topic: str
    entity: str
    robot: str
    source: str
    since_ns: int
    until_ns: int
    closes_ns: int
    concluded_ns: int
    heard_all: bool = True
    """Whether every outcome witnessed between the event and its conclusion was still remembered then."""
    cell: int = -1
    """Where the event lies in the experience of the model version that decided; -1 where that is not known."""
    verdict: Verdict | None = None
    shown: str = ""
    decided_by: str = ""
    decided_ns: int | None = None
    overruled: frozenset[str] = frozenset()
    """Outcomes that came later in source time, said something else, and were recorded as undecided."""

    @property
    def offset_ns(self) -> int:
        """From the event's own time to when it arrived."""
        return self.closes_ns - self.until_ns


class Ledger:
    """Entries by process, by event and by (entity, source time), and the next window to close.

    Every operation is O(log n) beside the entries it returns. Judged entries are kept for outcomes that come late, at
    most ``keep`` of them.
    """

    def __init__(self, scope: str, keep: int) -> None:
        self._by_robot = scope == "robot"
        self._keep = keep
        self._entries: dict[int, Entry] = {}
        self._of_event: dict[str, list[int]] = {}
        self._timeline: Timeline[int] = Timeline()
        self._closing: list[tuple[int, int]] = []
        self._judged: deque[int] = deque()
        self._open: set[int] = set()

    def get(self, process: int) -> Entry | None:
        """The entry of a process, open or judged; None where there is none any more."""
        return self._entries.get(process)

    def open(self, entry: Entry) -> None:
        """Enter a forecast. Its process must have none yet: a process concludes once."""
        process = entry.process
        self._entries[process] = entry
        others = self._of_event.get(entry.event)
        if others is None:
            self._of_event[entry.event] = [process]
        else:
            others.append(process)
        self._timeline.add(ANY if self._by_robot else entry.entity, entry.since_ns, process)
        self._open.add(process)
        heappush(self._closing, (entry.closes_ns, process))

    def judged(self, process: int) -> None:
        """The entry has a verdict now: no longer open, still kept for what comes late."""
        if process in self._open:
            self._open.remove(process)
            self._judged.append(process)
            while len(self._judged) > self._keep:
                self._forget(self._judged.popleft())

    def concerned(self, outcome: Outcome, longest_ns: int) -> Iterator[Entry]:
        """The entries that an outcome may judge, open or judged, earliest event first."""
        if outcome.event:
            candidates: Iterable[int] = self._of_event.get(outcome.event, ())
        else:
            candidates = self._around(outcome, longest_ns)
        for process in tuple(candidates):
            entry = self._entries[process]
            if concerns(outcome, entry, self._by_robot):
                yield entry

    def sole(self, outcome: Outcome) -> Entry | None:
        """The one entry that an outcome of its entity may judge, where that is plain to see; else None, and it is looked for."""
        if self._by_robot or outcome.event or outcome.entity == ANY or ANY in self._timeline:
            return None
        found = self._timeline.in_bucket(outcome.entity)
        if len(found) != 1:
            return None
        entry = self._entries[found[0][1]]
        if not entry.since_ns < outcome.at_ns <= entry.until_ns or outcome.topic != entry.topic:
            return None
        return entry

    def next_close_ns(self) -> int | None:
        """Kernel time at which the next open window has closed: its last instant still belongs to it."""
        while self._closing:
            closes_ns, process = self._closing[0]
            if process in self._open:
                return closes_ns + 1
            heappop(self._closing)
        return None

    def closed(self, now_ns: int) -> list[Entry]:
        """The open entries whose window has closed, first closed first. They stay open until judged."""
        found = []
        while self._closing and self._closing[0][0] < now_ns:
            closes_ns, process = heappop(self._closing)
            if process in self._open:
                found.append((closes_ns, process))
        for item in found:
            heappush(self._closing, item)
        return [self._entries[process] for _, process in found]

    def still_open(self) -> list[Entry]:
        """All open entries, by process."""
        return [self._entries[process] for process in sorted(self._open)]

    @property
    def open_now(self) -> int:
        """How many forecasts await their outcome."""
        return len(self._open)

    def _around(self, outcome: Outcome, longest_ns: int) -> list[int]:
        window = (outcome.at_ns - longest_ns - 1, outcome.at_ns)
        if self._by_robot or outcome.entity == ANY:
            return self._timeline.between(None, *window)
        own = self._timeline.between(outcome.entity, *window)
        return [*own, *self._timeline.between(ANY, *window)]

    def _bucket(self, entity: str) -> str:
        return ANY if self._by_robot else entity

    def _forget(self, process: int) -> None:
        entry = self._entries.pop(process)
        self._timeline.remove(self._bucket(entry.entity), entry.since_ns, process)
        rest = self._of_event[entry.event]
        rest.remove(process)
        if not rest:
            del self._of_event[entry.event]


def concerns(outcome: Outcome, entry: Entry, by_robot: bool) -> bool:
    """Whether the outcome may judge the entry: strictly later than its event, and named by it or inside its window.

    An outcome that names the event is a word on that event alone, whenever it comes.
    """
    if outcome.at_ns <= entry.since_ns:
        return False
    if outcome.event:
        return outcome.event == entry.event
    if outcome.topic != entry.topic or outcome.at_ns > entry.until_ns:
        return False
    return by_robot or outcome.entity in (entry.entity, ANY) or entry.entity == ANY
