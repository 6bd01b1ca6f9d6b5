"""What a user writes beside a peer that lacks it: outcomes with their verdicts, and limits in workload time."""

from __future__ import annotations

import heapq
import sqlite3
from collections.abc import Iterator
from pathlib import Path

from benchmarks.peers.treating import verdict


class Outcomes:
    """A table of outcomes with their verdicts, committed in groups: cheaper than a step of the peer's own for each."""

    def __init__(self, path: Path, full_sync: bool) -> None:
        self._db = sqlite3.connect(path, isolation_level=None)
        self._db.execute("PRAGMA journal_mode=WAL")
        self._db.execute(f"PRAGMA synchronous={'FULL' if full_sync else 'NORMAL'}")
        self._db.execute("CREATE TABLE IF NOT EXISTS outcomes(entity TEXT PRIMARY KEY, label TEXT, verdict TEXT) WITHOUT ROWID")
        self._waiting: list[tuple[str, str, str]] = []

    def add(self, entity: str, predicted: str, label: str, acted_on: bool) -> None:
        """The outcome of an event whose result is known."""
        self._waiting.append((entity, label, verdict(predicted, label, acted_on)))

    def commit(self) -> None:
        """Make durable what was added."""
        if not self._waiting:
            return
        self._db.execute("BEGIN")
        self._db.executemany("INSERT OR IGNORE INTO outcomes VALUES (?, ?, ?)", self._waiting)
        self._db.execute("COMMIT")
        self._waiting.clear()

    def rows(self) -> Iterator[tuple[str, str, str]]:
        """All that was recorded."""
        return iter(self._db.execute("SELECT entity, label, verdict FROM outcomes"))

    def close(self) -> None:
        """Let go of the file."""
        self._db.close()


class Limits:
    """Who waits until when, in workload time."""

    def __init__(self) -> None:
        self._heap: list[tuple[int, str]] = []
        self.waiting: dict[str, int] = {}

    def begin(self, entity: str, until_ns: int) -> None:
        """Somebody waits from now on."""
        self.waiting[entity] = until_ns
        heapq.heappush(self._heap, (until_ns, entity))

    def end(self, entity: str) -> bool:
        """It came; False where nobody waits for it."""
        return self.waiting.pop(entity, None) is not None

    def late(self, at_ns: int) -> list[str]:
        """Whose limit has passed; they wait no more."""
        found = []
        while self._heap and self._heap[0][0] <= at_ns:
            _, entity = heapq.heappop(self._heap)
            if self.end(entity):
                found.append(entity)
        return found
