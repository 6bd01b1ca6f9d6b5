"""The floor: what hardware and libraries allow for W. Each stage is measured in two implementations, and the faster one counts.

The stages are what nobody who keeps W's promises can leave out: decode and validate each message, make features, choose by the
model in micro-batches, append what must survive in group commits, and for each step one heap operation and one resumption of a
coroutine. ``of_floor.py`` puts the faster ones together to a program that comes to W's final states.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable

import apsw
import msgspec
import numpy as np

from benchmarks.peers.floor_steps import Steps, Treat, treat_async, treat_generator
from benchmarks.peers.lean import COLUMNS, Floats, Lean, features, places
from benchmarks.peers.messages import TREATMENTS, AnyMessage, Event, Evidence, Outcome, decode
from benchmarks.peers.running import Run
from benchmarks.peers.treating import WAITS

Row = tuple[int, str, bytes]

_decode_lines = msgspec.json.Decoder(AnyMessage).decode_lines

# --- decode and validate ---


def decode_each(messages: list[bytes]) -> list[AnyMessage]:
    """One by one."""
    return [decode(text) for text in messages]


def decode_together(messages: list[bytes]) -> list[AnyMessage]:
    """A batch as one text."""
    return _decode_lines(b"\n".join(messages))


def decode_by_hand(messages: list[bytes]) -> list[AnyMessage]:
    """The standard library, validated afterwards."""
    return [msgspec.convert(json.loads(text), AnyMessage) for text in messages]


# --- features ---

_UNIT = [tuple(float(at == column) for column in range(COLUMNS - 3)) for at in range(COLUMNS - 3)]


def features_listed(events: list[Event]) -> Floats:
    """Each row built as a list."""
    rows = []
    for event in events:
        row = [0.0] * COLUMNS
        for at in places(event):
            row[at] = 1.0
        row[-3:] = (event.load, event.x, event.y)
        rows.append(row)
    return np.array(rows).reshape(len(rows), COLUMNS)


# --- the model ---


def forward_64(lean: Lean) -> Callable[[Floats], list[tuple[int, int]]]:
    """In double precision."""
    return lambda rows: _best(lean.logits(rows))


def forward_32(lean: Lean) -> Callable[[Floats], list[tuple[int, int]]]:
    """In single precision."""
    half = Lean([layer.astype(np.float32) for layer in lean.layers])
    return lambda rows: _best(half.logits(rows.astype(np.float32)))


def _best(out: Floats) -> list[tuple[int, int]]:
    cut = len(TREATMENTS)
    return list(zip(out[:, :cut].argmax(1).tolist(), out[:, cut:].argmax(1).tolist(), strict=True))


# --- append ---


class Table:
    """Rows in SQLite, many to a statement, many statements to a commit."""

    def __init__(self, path: str, full_sync: bool) -> None:
        self.db = apsw.Connection(path)
        self.db.execute("PRAGMA journal_mode=WAL")
        self.db.execute(f"PRAGMA synchronous={'FULL' if full_sync else 'NORMAL'}")
        self.db.execute("CREATE TABLE IF NOT EXISTS w(position INTEGER PRIMARY KEY, entity TEXT, record BLOB) STRICT")

    def append(self, rows: list[Row]) -> None:
        """One commit."""
        with self.db:
            for begin in range(0, len(rows), 256):
                part = rows[begin : begin + 256]
                slots = ",".join(["(?,?,?)"] * len(part))
                self.db.execute(f"INSERT INTO w VALUES {slots}", [value for row in part for value in row])


class ManyTable(Table):
    """The same with executemany."""

    def append(self, rows: list[Row]) -> None:
        """One commit."""
        with self.db:
            self.db.executemany("INSERT INTO w VALUES (?,?,?)", rows)


class File:
    """Bytes at the end of a file: nothing can be looked up in it. Measured beside the floor, not part of it."""

    def __init__(self, path: str, full_sync: bool) -> None:
        self._file = os.open(path, os.O_CREAT | os.O_WRONLY | os.O_APPEND)
        self._sync = full_sync

    def append(self, rows: list[Row]) -> None:
        """One write."""
        os.write(self._file, b"".join([b"%d %s %d %s\n" % (row[0], row[1].encode(), len(row[2]), row[2]) for row in rows]))
        if self._sync:
            os.fdatasync(self._file)


def measured(run: Run) -> dict[str, dict[str, float]]:
    """CPU microseconds per event of each stage and implementation; the least of three passes, taken by turns.

    Batches are those of the load: windows, or what comes within a group's time at its rate.
    """
    messages, load = run.messages, run.load
    window = max(1, round(2.2 * load.rate * load.group_s)) if load.rate else load.window
    batches = [messages[begin : begin + window] for begin in range(0, len(messages), window)]
    decoded = [decode_each(batch) for batch in batches]
    events = [[each for each in batch if type(each) is Event] for batch in decoded]
    count = sum(map(len, events))
    rows = [features(batch) for batch in events]
    labels = [[label for _, label in run.lean.choose(batch)] for batch in events]
    lines = _rows(batches, decoded)

    def steps(treat: Treat) -> Callable[[], None]:
        def work() -> None:
            found = Steps(treat, {}, {})
            for batch, chosen in zip(events, labels, strict=True):
                for event, label in zip(batch, chosen, strict=True):
                    found.begin(event, label)
                for _ in found.run():
                    pass
                for event in batch:
                    if event.category == WAITS:
                        found.wake(event.entity, 1.0)
                for _ in found.run():
                    pass

        return work

    number = 0

    def append(kind: type[Table] | type[File]) -> Callable[[], None]:
        nonlocal number
        number += 1
        table = kind(str(run.store / f"stage{number}.db"), run.load.full_sync)
        passed = 0

        def work() -> None:
            nonlocal passed
            for part in lines:
                table.append([(place + passed, entity, record) for place, entity, record in part])
            passed += 1_000_000

        return work

    def each(function: Callable[[list[object]], object], batches: list[list[object]]) -> Callable[[], None]:
        def work() -> None:
            for batch in batches:
                function(batch)

        return work

    work: dict[str, dict[str, Callable[[], None]]] = {
        "decode": {
            "each": each(decode_each, batches),
            "together": each(decode_together, batches),
            "by hand": each(decode_by_hand, batches),
        },
        "features": {"vectorised": each(features, events), "listed": each(features_listed, events)},
        "forward": {"float64": each(forward_64(run.lean), rows), "float32": each(forward_32(run.lean), rows)},
        "append": {"multi-row": append(Table), "executemany": append(ManyTable)},
        "raw file": {"write": append(File)},
        "steps": {"coroutine": steps(treat_async), "generator": steps(treat_generator)},
    }
    found = {stage: dict.fromkeys(kinds, float("inf")) for stage, kinds in work.items()}
    for _ in range(3):
        for stage, kinds in work.items():
            for name, function in kinds.items():
                began = time.process_time()
                function()
                found[stage][name] = min(found[stage][name], (time.process_time() - began) * 1e6 / count)
    for path in run.store.glob("stage*"):
        path.unlink()
    return {stage: {name: round(us, 3) for name, us in kinds.items()} for stage, kinds in found.items()}


def _rows(batches: list[list[bytes]], decoded: list[list[AnyMessage]]) -> list[list[Row]]:
    position = 0
    found = []
    for texts, messages in zip(batches, decoded, strict=True):
        rows: list[Row] = []
        for text, message in zip(texts, messages, strict=True):
            if isinstance(message, Event | Evidence | Outcome):
                rows.append((position, message.entity, text if isinstance(message, Outcome) else b"123456789012" + text))
                position += 1
        found.append(rows)
    return found
