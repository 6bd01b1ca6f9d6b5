"""What is known of the recordings: when each ended or had a gap, and by how much its clock is off kernel time."""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.validation.ledger import Entry


class Recordings:
    """By source. State changes only by what the journal's records say."""

    def __init__(self) -> None:
        self._ended_ns: dict[str, int] = {}
        self._broken_ns: dict[str, int] = {}
        self._offset_ns: dict[str, int] = {}

    def opened(self, source: str, offset_ns: int) -> None:
        """It is read (again); ``offset_ns`` takes its clock to kernel time."""
        self._ended_ns.pop(source, None)
        self._offset_ns[source] = offset_ns

    def ended(self, source: str, at_ns: int) -> None:
        """It was read to its end, or broke off."""
        self._ended_ns[source] = at_ns

    def broken(self, source: str, at_ns: int) -> None:
        """It has a gap, or an input that could not be read: that may have been an outcome."""
        self._broken_ns[source] = at_ns

    def since_ns(self, event: Event) -> int:
        """The event's own instant in kernel time."""
        return event.stamp.source_ns + self._offset_ns.get(event.source, 0)

    def in_kernel_time(self, outcome: Outcome) -> Outcome:
        """The outcome with its instant in kernel time: two recordings' own clocks cannot be compared."""
        offset_ns = self._offset_ns.get(outcome.source, 0)
        return msgspec.structs.replace(outcome, at_ns=outcome.at_ns + offset_ns) if offset_ns else outcome

    def reaches(self, outcome: Outcome, entry: Entry) -> bool:
        """Whether an outcome may speak of a recording's event: another recording, begun after that one's end, does not."""
        ended_ns = self._ended_ns.get(entry.source)
        if ended_ns is None:
            return True
        apart = bool(outcome.source) and outcome.source != entry.source and not outcome.event
        return not (apart and outcome.at_ns >= ended_ns)

    def doubt(self, entry: Entry) -> str:
        """Why silence over the entry's window says nothing; empty where the recording was whole."""
        ended_ns = self._ended_ns.get(entry.source)
        if ended_ns is not None and ended_ns < entry.closes_ns:
            return ENDED
        broken_ns = self._broken_ns.get(entry.source)
        if broken_ns is not None and entry.since_ns + entry.offset_ns <= broken_ns:
            return "the recording has a gap within the window, or an input that could not be read: what came then is not known"
        return "" if entry.heard_all else "outcomes of its window are no longer remembered"


ENDED = "the recording ended or broke before the window closed"
