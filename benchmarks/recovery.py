"""Recovery: how long a mind takes to take up a journal, against the journal's length.

    python -m benchmarks.recovery --events 10000 20000 40000 --open-one-in 100

writes synthetic events (eight fields, automatic, judged; one in so many stays open) as the entries that a kernel gives, then
lets a new kernel recover from them: once from a journal that keeps all of them, and where that is more than is kept by default,
once from what is kept, with all open processes. ``read_s`` is what reading and unpacking the rows takes by itself,
``recovery_s`` the whole: each record applied in each room again, and open processes rebuilt. Medians of three, in seconds of
CPU.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec

from benchmarks import growth
from benchmarks.synthetic import Stream
from wakeful.drivers.assembly import assemble
from wakeful.drivers.blobs import JournalBlobs
from wakeful.facts.settings import MindSettings
from wakeful.journal import SqliteJournal, open_journal
from wakeful.journal.retention import KEEP_ALL, Retention

_REPEATS = 3


class Recovered(msgspec.Struct):
    """One journal's figures."""

    events: int
    kept: int
    open: int
    file_mb: float
    read_s: float
    recovery_s: float
    us_per_event: float


def measure(folder: Path, events: int, open_one_in: int, retention: Retention) -> Recovered:
    """Write a journal of so many events, compact it, and recover from it."""
    stream = Stream(days=1.0, events=events, seed=0, open_one_in=open_one_in, model_one_in=10 * events)
    path = folder / f"{events}-{retention.events}.db"
    with open_journal(path, full_sync=False, retention=retention) as journal:
        journal.commit(stream.begin(), {}, {})
        for _ in range(0, events, growth.EVENTS_PER_COMMIT):
            group = [entry for _ in range(growth.EVENTS_PER_COMMIT) for entry in stream.next()]
            journal.commit(group, {}, {})
        while retention.events and journal.tidy(1):
            pass
    with open_journal(path, read_only=True) as journal:
        read_s = statistics.median(_seconds(journal, recover=False) for _ in range(_REPEATS))
        recovery_s = statistics.median(_seconds(journal, recover=True) for _ in range(_REPEATS))
    return Recovered(
        events=events,
        kept=min(events, retention.events or events),
        open=stream.open,
        file_mb=round(path.stat().st_size / 1e6, 1),
        read_s=round(read_s, 2),
        recovery_s=round(recovery_s, 2),
        us_per_event=round(recovery_s / events * 1e6, 1),
    )


def _seconds(journal: SqliteJournal, *, recover: bool) -> float:
    kernel, _ = assemble("service_robot", MindSettings(step_s=0.0))
    began_s = time.process_time()
    if recover:
        kernel.recover(journal.entries(), journal.state(), JournalBlobs(journal))
    else:
        for _ in journal.entries():
            pass
    return time.process_time() - began_s


def rows(sizes: list[int], open_one_in: int) -> Iterator[Recovered]:
    """One row for each size."""
    with tempfile.TemporaryDirectory() as folder:
        for events in sizes:
            for retention in (KEEP_ALL, Retention()):
                if retention is KEEP_ALL or events > retention.events:
                    yield measure(Path(folder), events, open_one_in, retention)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--events", type=int, nargs="+", default=[5_000, 10_000, 20_000])
    parser.add_argument("--open-one-in", type=int, default=100)
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    names = Recovered.__struct_fields__
    if not chosen.json:
        print("  ".join(name.rjust(max(9, len(name))) for name in names))
    for row in rows(chosen.events, chosen.open_one_in):
        if chosen.json:
            print(msgspec.json.encode(row).decode(), flush=True)
        else:
            print("  ".join(str(getattr(row, name)).rjust(max(9, len(name))) for name in names), flush=True)


if __name__ == "__main__":
    main()
