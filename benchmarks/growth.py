"""Growth: an endless stream keeps the journal under a bound, with open processes, debt and provenance as they were.

    python -m benchmarks.growth --events 10000000 --days 30

writes synthetic events (eight fields, automatic, judged) straight into a journal, as the entries that a kernel gives, with
the documented retention; after each commit compaction has one turn, as a mind's drivers give it (``drivers/tidying.py``). One
event in 2,000 stays open, one in 2,000 ends in debt, and one in 50,000 comes with a new model. Prints the file's size over
time, and in the end whether what is owed is there.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec

from benchmarks.synthetic import Stream
from wakeful.drivers.tidying import Tidying
from wakeful.facts.lines import Compacted
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.retention import Retention

#: As many automatic events as a mind that reads a recording commits together (``drivers/simulated.py``).
EVENTS_PER_COMMIT = 64

#: The audit reads every line that is left: above so many events it takes longer than the stream.
AUDITED = 200_000


class Size(msgspec.Struct):
    """The journal at one instant of the stream. ``file_mb`` is what lies on the disk, ``wal_mb`` its write-ahead file; a turn is
    what compaction does after one commit."""

    events: int
    day: float
    file_mb: float
    wal_mb: float
    open: int
    debt: int
    cpu_us_per_event: float
    tidy_us_per_event: float
    longest_turn_ms: float
    longest_turn_cpu_ms: float


class Growth:
    """Writes a stream into a journal, compacting between the commits.

    Args:
        path: of the journal; made.
        events: how many.
        days: of simulated time that they take.
        retention: what the journal keeps.
        events_per_commit: how many are committed together.
    """

    def __init__(
        self, path: Path, events: int, days: float, retention: Retention, events_per_commit: int = EVENTS_PER_COMMIT
    ) -> None:
        self.stream = Stream(days, events, seed=0)
        self.journal = open_journal(path, full_sync=False, retention=retention)
        self._tidying = Tidying(self.journal)
        self._events_per_commit = events_per_commit
        self._path = path
        self._events, self._days = events, days
        self._spent_s = self._longest_s = self._longest_cpu_s = 0.0

    def run(self, rows: int) -> Iterator[Size]:
        """Yields the journal's size so many times, and at the end."""
        self.journal.commit(self.stream.begin(), {}, {})
        began_s, done, told = time.process_time(), 0, 0
        while done < self._events:
            group = [entry for _ in range(self._events_per_commit) for entry in self.stream.next()]
            self.journal.commit(group, {}, self.stream.blobs)
            self.stream.blobs.clear()
            done += self._events_per_commit
            self._turn()
            if done * rows // self._events > told or done >= self._events:
                told = done * rows // self._events
                yield self._size(done, began_s)

    def finish(self) -> None:
        """Give up all that is old enough by now."""
        while self.journal.tidy(least_events=1):
            pass

    def _turn(self) -> None:
        turn_s, turn_cpu_s = time.perf_counter(), time.process_time()
        self._tidying.turn()
        spent_s = time.process_time() - turn_cpu_s
        self._spent_s += spent_s
        self._longest_cpu_s = max(self._longest_cpu_s, spent_s)
        self._longest_s = max(self._longest_s, time.perf_counter() - turn_s)

    def _size(self, done: int, began_s: float) -> Size:
        wal = self._path.with_name(self._path.name + "-wal")
        longest_s, self._longest_s = self._longest_s, 0.0
        longest_cpu_s, self._longest_cpu_s = self._longest_cpu_s, 0.0
        return Size(
            events=done,
            day=round(self._days * done / self._events, 2),
            file_mb=round(self._path.stat().st_size / 1e6, 1),
            wal_mb=round(wal.stat().st_size / 1e6, 1) if wal.exists() else 0.0,
            open=self.stream.open,
            debt=self.stream.debt,
            cpu_us_per_event=round((time.process_time() - began_s) / done * 1e6, 1),
            tidy_us_per_event=round(self._spent_s / done * 1e6, 2),
            longest_turn_ms=round(longest_s * 1e3, 1),
            longest_turn_cpu_ms=round(longest_cpu_s * 1e3, 1),
        )

    def missing(self) -> tuple[int, int, Compacted]:
        """How many lines of what is owed lay in what was compacted, how many of them are not as they were, and the counts of the
        rest."""
        boundary = self.journal.compacted()
        owed = {line.position: line for lines in self.stream.kept.values() for line in lines if line.position <= boundary}
        looked, gone = 0, Compacted(first=1, lines=0)
        for line in self.journal.lines():
            if line.position > boundary:
                break
            if isinstance(line.record, Compacted):
                gone = Compacted(first=1, lines=gone.lines + line.record.lines, admitted=gone.admitted + line.record.admitted)
            elif owed.get(line.position) == line:
                looked += 1
        return len(owed), len(owed) - looked, gone


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--events", type=int, default=200_000)
    parser.add_argument("--days", type=float, default=30.0)
    parser.add_argument("--keep-events", type=int, default=Retention().events)
    parser.add_argument("--events-per-commit", type=int, default=EVENTS_PER_COMMIT)
    parser.add_argument("--rows", type=int, default=20, help="lines of the table")
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    retention = msgspec.structs.replace(Retention(), events=chosen.keep_events)
    with tempfile.TemporaryDirectory() as folder:
        growth = Growth(Path(folder) / "mind.db", chosen.events, chosen.days, retention, chosen.events_per_commit)
        names = Size.__struct_fields__
        if not chosen.json:
            print("  ".join(name.rjust(max(9, len(name))) for name in names))
        for size in growth.run(chosen.rows):
            if chosen.json:
                print(msgspec.json.encode(size).decode(), flush=True)
            else:
                cells = (str(getattr(size, name)).rjust(max(9, len(name))) for name in names)
                print("  ".join(cells), flush=True)
        growth.finish()
        owed, missing, gone = growth.missing()
        print(f"compacted: {gone.admitted:,} events, {gone.lines:,} lines")
        print(f"of what is owed {owed:,} lines lie there, {missing} of them are missing")
        if chosen.events <= AUDITED:
            report = audit(growth.journal)
            print(f"audit: {'clean' if report.ok else report.first_offender}, {report.lines:,} lines")
        peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"peak memory {peak_mb:.0f} MB")
        growth.journal.close()


if __name__ == "__main__":
    main()
