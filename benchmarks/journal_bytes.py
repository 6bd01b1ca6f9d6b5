"""What an automatic event takes of the journal: bytes of the file, and CPU to encode and insert; beside JSON lines.

    python -m benchmarks.journal_bytes

Synthetic events of eight fields, as in benchmarks/growth.py: each is covered (admitted, created, decided) and has run; its
outcome, with verdict and experience, is counted apart. ``bytes`` are of the closed file, all tables, divided by the events;
``us`` are of CPU, user and system, in commits of 200 events, without waiting for the disk. Medians of five, in one run.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import apsw
import msgspec

from benchmarks.growth import EVENTS_PER_COMMIT
from benchmarks.synthetic import Stream
from wakeful.facts.packs import Entry, Pack, Validated, expanded, last_position
from wakeful.journal import open_journal
from wakeful.journal.retention import KEEP_ALL

_REPEATS = 5

Write = Callable[[Path, list[list[Entry]]], None]


class Figures(msgspec.Struct):
    """One way to write, with and without what outcomes add."""

    system: str
    bytes_per_event: float
    bytes_per_outcome: float
    us_per_event: float
    us_per_outcome: float


def wakeful(path: Path, groups: list[list[Entry]]) -> None:
    """The journal as it is."""
    with open_journal(path, full_sync=False, retention=KEEP_ALL) as journal:
        for group in groups:
            journal.commit(group, {}, {})


def json_lines(path: Path, groups: list[list[Entry]]) -> None:
    """Schema 1 of wakeful 0.1: each line a row of JSON, with indexes by event, process and kind."""
    db = apsw.Connection(str(path))
    db.execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL")
    db.execute("CREATE TABLE lines(position INTEGER PRIMARY KEY, at_ns INT, kind TEXT, event TEXT, process INT, record TEXT)")
    for column in ("event", "process", "kind"):
        db.execute(f"CREATE INDEX lines_by_{column} ON lines({column})")
    encode = msgspec.json.Encoder().encode
    for group in groups:
        with db:
            for line in expanded(group):
                record = line.record
                event, process = getattr(record, "event", None), getattr(record, "process", None)
                event = getattr(event, "id", event)
                row = (line.position, line.at_ns, type(record).__name__, event, process, encode(record).decode())
                db.execute("INSERT INTO lines VALUES (?,?,?,?,?,?)", row)
    db.close()


def measure(system: str, write: Write, events: int) -> Figures:
    """The figures of one way to write."""
    costs: list[tuple[float, float]] = []
    for with_outcomes in (False, True):
        groups = _groups(events, with_outcomes)
        seconds = []
        for _ in range(_REPEATS):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "mind.db"
                began_s = time.process_time()
                write(path, groups)
                seconds.append(time.process_time() - began_s)
                size = path.stat().st_size
        costs.append((size / events, statistics.median(seconds) / events * 1e6))
    (bytes_, us), (bytes_with, us_with) = costs
    return Figures(system, round(bytes_), round(bytes_with - bytes_), round(us, 1), round(us_with - us, 1))


def _groups(events: int, with_outcomes: bool) -> list[list[Entry]]:
    stream = Stream(days=1.0, events=events, seed=0, open_one_in=events + 9, model_one_in=events + 9)
    groups, position = [], 1
    for start in range(0, events, EVENTS_PER_COMMIT):
        group: list[Entry] = [] if start else [*stream.begin()]
        position += len(group)
        for _ in range(min(EVENTS_PER_COMMIT, events - start)):
            for entry in stream.next():
                if with_outcomes or not (isinstance(entry, Pack) and isinstance(entry.burst, Validated)):
                    placed = msgspec.structs.replace(entry, position=position)
                    group.append(placed)
                    position = last_position(placed) + 1
        groups.append(group)
    return groups


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--events", type=int, default=10_000)
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    names = Figures.__struct_fields__
    if not chosen.json:
        print("  ".join(name.rjust(max(10, len(name))) for name in names))
    for system, write in (("wakeful", wakeful), ("json lines", json_lines)):
        row = measure(system, write, chosen.events)
        if chosen.json:
            print(msgspec.json.encode(row).decode())
        else:
            print("  ".join(str(getattr(row, name)).rjust(max(10, len(name))) for name in names), flush=True)


if __name__ == "__main__":
    main()
