"""What stands outside the mind and survives its crashes: what was acknowledged to it, and what the callee did for it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from wakeful.contracts.journal import Journal, JournalError
from wakeful.facts.asking import Kind, Safety
from wakeful.facts.lines import Answered, Asked, Created, Line
from wakeful.facts.packs import Entry, expanded
from wakeful.journal.sqlite import SqliteJournal


class Ledger:
    """Kept from life to life. Counts what must not happen.

    ``lost``: acknowledged lines that were not there, or not the same, when the journal was opened again. ``repeated``: calls
    that the callee was asked for although their answer had been committed, or that nobody had committed as intended.
    ``in_doubt``: calls made a second time because no answer had been committed.
    """

    def __init__(self) -> None:
        self.lost = 0
        self.repeated = 0
        self.in_doubt = 0
        self.calls = 0
        self.commits: list[int] = []
        self.known: list[Line] = []
        self._attempted: list[Line] = []
        self._event_of: dict[int, str] = {}
        self._intended: dict[tuple[str, str], dict[tuple[int, int], int]] = {}

    def lines(self, after: int = 0) -> Iterator[Line]:
        """All that stands in the journal, as far as is known."""
        return iter(self.known[after:])

    def attempt(self, lines: Sequence[Line]) -> None:
        """A commit is about to be tried: from now on its lines may be there."""
        self._attempted = list(lines)

    def acknowledge(self) -> None:
        """The commit returned: from now on its lines must be there."""
        self._take(self._attempted)

    def reopened(self, found: Sequence[Line]) -> None:
        """The journal was opened again: all that was acknowledged must be there, and nothing that was never tried."""
        known = len(self.known)
        self.lost += sum(before != now for before, now in zip(self.known, found, strict=False))
        self.lost += max(0, known - len(found))
        more = list(found[known:])
        if more and more != self._attempted:
            self.lost += 1
        self.known = list(found[:known])
        self._take(more)

    def _take(self, lines: Sequence[Line]) -> None:
        self._attempted = []
        self.known.extend(lines)
        if lines:
            self.commits.append(lines[-1].position)
        for line in lines:
            record = line.record
            if isinstance(record, Created):
                self._event_of[record.process] = record.event
            elif isinstance(record, Asked) and record.kind is Kind.CALL:
                place = self._event_of[record.process], record.key
                self._intended.setdefault(place, {})[record.process, record.seq] = 0
            elif isinstance(record, Answered) and record.kind is Kind.CALL:
                place = self._event_of[record.process], record.key
                self._intended[place].pop((record.process, record.seq), None)

    def does(self, event: str, what: str, safety: Safety) -> str:
        """The callee does something, once more."""
        self.calls += 1
        open_calls = self._intended.get((event, what))
        if not open_calls:
            self.repeated += 1
            return "not intended"
        place = min(open_calls, key=lambda each: (open_calls[each], each))
        if open_calls[place]:
            self.in_doubt += 1
            self.repeated += safety == "effect"
        open_calls[place] += 1
        return f"{what} of {event}"


class Known:
    """A journal that is open, its lines as the ledger knows them to stand in the file: nothing is read twice."""

    def __init__(self, ledger: Ledger, journal: SqliteJournal) -> None:
        self._known = ledger.known
        self.state = journal.state
        self.blob = journal.blob
        self.commits = journal.commits
        self.snapshot = journal.snapshot

    def lines(self, after: int = 0) -> Iterator[Line]:
        """As the journal."""
        return iter(self._known[after:])


class Witness:
    """A journal that notes in the ledger what it acknowledges, and whose commits fail when the plan says so.

    Args:
        inner: the journal proper.
        ledger: kept over crashes.
        failing: which commit of this life fails, counted from 1; 0: none.
    """

    def __init__(self, inner: Journal, ledger: Ledger, failing: int = 0) -> None:
        self.inner = inner
        self._ledger = ledger
        self._failing = failing
        self._commits = 0
        ledger.reopened(list(inner.lines()))

    @property
    def last(self) -> int:
        """As the journal."""
        return self.inner.last

    def commit(self, entries: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """As the journal, watched."""
        self._commits += 1
        if self._commits == self._failing:
            raise JournalError("the plan lets this commit fail; nothing of it was kept")
        lines = list(expanded(entries))
        self._ledger.attempt(lines)
        self.inner.commit(entries, state, blobs)
        self._ledger.acknowledge()

    def entries(self, after: int = 0) -> Iterator[Entry]:
        """As the journal."""
        return self.inner.entries(after)

    def lines(self, after: int = 0) -> Iterator[Line]:
        """As the journal."""
        return self.inner.lines(after)

    def state(self) -> dict[str, bytes]:
        """As the journal."""
        return self.inner.state()

    def blob(self, name: str) -> bytes:
        """As the journal."""
        return self.inner.blob(name)

    def close(self) -> None:
        """As the journal."""
        self.inner.close()

    def tidy(self, least_events: int = 0) -> bool:  # noqa: ARG002
        """Nothing is compacted here: the ledger holds every line against the file (compaction: ``tests/journal/compaction``)."""
        return False
