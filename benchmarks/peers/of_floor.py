"""The floor: what hardware and libraries allow for W. Each stage is measured in two implementations, and the faster one counts.

The stages are what nobody who keeps W's promises can leave out: decode and validate each message, make features, choose by the
model in micro-batches, append what must survive in group commits, and for each step one heap operation and one resumption of a
coroutine. ``Floor.run`` puts the faster ones together to a program that comes to W's final states.
"""

from __future__ import annotations

import heapq
import json
import os
import time
from collections.abc import Callable, Coroutine, Generator, Iterator
from types import coroutine

import apsw
import msgspec
import numpy as np

from benchmarks.peers.lean import COLUMNS, Floats, Lean, features, places
from benchmarks.peers.messages import LABELS, TREATMENTS, AnyMessage, Event, Evidence, Message, Outcome, decode
from benchmarks.peers.running import Run, now_ns, size_of
from benchmarks.peers.treating import LIMIT_NS, WAITS, conclude, final, look, verdict, weigh

Row = tuple[int, str, bytes]

_decode_lines = msgspec.json.Decoder(AnyMessage).decode_lines
_KINDS = {kind.__struct_config__.tag: kind for kind in Message.__subclasses__()}

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


# --- steps: a heap operation and a resumption each ---


@coroutine
def _rest() -> Generator[None, float | None, float | None]:
    return (yield)


async def treat_async(event: Event, label: str) -> tuple[float | None, int]:
    """Three steps as a coroutine."""
    await _rest()
    seen = look(event.entity, event.load)
    waits = event.category == WAITS
    reading = await _rest() if waits else 0.0
    await _rest()
    seen = weigh(seen, reading)
    await _rest()
    return (reading if waits else None), conclude(seen, label)


def treat_generator(event: Event, label: str) -> Generator[None, float | None, tuple[float | None, int]]:
    """Three steps as a generator."""
    yield
    seen = look(event.entity, event.load)
    waits = event.category == WAITS
    reading = (yield) if waits else 0.0
    yield
    seen = weigh(seen, reading)
    yield
    return (reading if waits else None), conclude(seen, label)


Treat = Callable[[Event, str], "Coroutine[None, float | None, tuple[float | None, int]]"]


class Steps:
    """Runs treatments: a heap of who is ready, a table of who waits, a heap of limits."""

    def __init__(self, treat: Treat, stepped: dict[str, int], resumed: dict[str, int]) -> None:
        self._treat = treat
        self._ready: list[tuple[int, int, object, Event, float | None]] = []
        self._limits: list[tuple[int, int, str]] = []
        self._waits: dict[str, tuple[object, Event]] = {}
        self._number = 0
        self._stepped, self._resumed = stepped, resumed

    def begin(self, event: Event, label: str) -> None:
        """A process for an event."""
        thinks = self._treat(event, label)
        thinks.send(None)
        self._push(thinks, event, None)

    def wake(self, entity: str, reading: float | None) -> bool:
        """What it waited for came, or never will; False where nobody waits."""
        waiting = self._waits.pop(entity, None)
        if waiting is None:
            return False
        self._resumed[entity] = now_ns()
        self._push(*waiting, reading)
        return True

    def late(self, at_ns: int) -> Iterator[str]:
        """Whose limit has passed."""
        while self._limits and self._limits[0][0] <= at_ns:
            entity = heapq.heappop(self._limits)[2]
            if entity in self._waits:
                yield entity

    def run(self) -> Iterator[tuple[Event, float | None, int]]:
        """Step by step until nobody is ready; who has concluded."""
        while self._ready:
            _, number, thinks, event, given = heapq.heappop(self._ready)
            try:
                thinks.send(given)
            except StopIteration as done:
                yield (event, *done.value)
                continue
            if event.entity not in self._stepped:
                self._stepped[event.entity] = now_ns()
                if event.category == WAITS:
                    self._waits[event.entity] = (thinks, event)
                    heapq.heappush(self._limits, (event.at_ns + LIMIT_NS, number, event.entity))
                    continue
            self._push(thinks, event, None)

    def _push(self, thinks: object, event: Event, given: float | None) -> None:
        self._number += 1
        heapq.heappush(self._ready, (event.at_ns, self._number, thinks, event, given))


class Floor:
    """The faster stages, put together."""

    def __init__(self, run: Run, _variant: str) -> None:
        self._run = run
        self._stages = measured(run)
        fastest = {name: min(found, key=found.__getitem__) for name, found in self._stages.items()}
        self._decode = {"each": decode_each, "together": decode_together, "by hand": decode_by_hand}[fastest["decode"]]
        self._features = {"vectorised": features, "listed": features_listed}[fastest["features"]]
        self._forward = (forward_64 if fastest["forward"] == "float64" else forward_32)(run.lean)
        kind = Table if fastest["append"] == "multi-row" else ManyTable
        self._table = kind(str(run.store / "floor.db"), run.load.full_sync)
        self._treat = treat_async if fastest["steps"] == "coroutine" else treat_generator
        self._finals: list[str] = []

    @property
    def extra(self) -> dict[str, object]:
        """Each stage's microseconds for an event, and the sum of the faster ones: the floor."""
        return {
            "stages_us": self._stages,
            "floor_us": sum(min(found.values()) for name, found in self._stages.items() if name != "raw file"),
        }

    def run(self) -> None:
        """Micro-batches of a window each."""
        run, times = self._run, self._run.times
        steps = Steps(self._treat, times.stepped, times.resumed)
        early: dict[str, float] = {}
        results: dict[str, tuple[str, str, float | None, int]] = {}
        position = 0

        def concluded_now(done: Iterator[tuple[Event, float | None, int]]) -> None:
            for event, reading, concluded in done:
                name, predicted, _, _ = results[event.entity]
                results[event.entity] = name, predicted, reading, concluded

        for came, texts in run.windows():
            messages = self._decode(texts)
            events = [message for message in messages if type(message) is Event]
            chosen = self._forward(self._features(events))
            rows: list[Row] = []
            at = 0
            for came_ns, text, message in zip(came, texts, messages, strict=True):
                for entity in steps.late(message.at_ns):
                    steps.wake(entity, None)
                    concluded_now(steps.run())
                    rows.append((position, entity, b"%d" % results[entity][3]))
                    position += 1
                kind = type(message)
                if kind is Event:
                    treatment, label = chosen[at]
                    at += 1
                    entity = message.entity
                    times.came[entity] = came_ns
                    results[entity] = TREATMENTS[treatment], LABELS[label], None, 0
                    steps.begin(message, LABELS[label])
                    if entity in early:
                        concluded_now(steps.run())
                        steps.wake(entity, early[entity])
                    concluded_now(steps.run())
                    rows.append((position, entity, b"%d%d%d%s" % (treatment, label, results[entity][3], text)))
                elif kind is Evidence:
                    times.read.setdefault(message.entity, came_ns)
                    if not steps.wake(message.entity, message.value):
                        early.setdefault(message.entity, message.value)
                    concluded_now(steps.run())
                    state = results[message.entity][3] if message.entity in results else 0
                    rows.append((position, message.entity, b"%d%s" % (state, text)))
                elif kind is Outcome:
                    rows.append((position, message.entity, text))
                else:
                    continue
                position += 1
                if kind is Outcome:
                    name, predicted, reading, concluded = results[message.entity]
                    judged = verdict(predicted, message.label, message.acted_on)
                    self._finals.append(final(message.entity, name, predicted, reading, concluded, message.label, judged))
            self._table.append(rows)
            run.acknowledge([event.entity for event in events])

    def finals(self) -> list[str]:
        """What the assembled stages came to."""
        self._table.db.close()
        return self._finals

    def stored_bytes(self) -> int:
        """The table's file."""
        return size_of(self._run.store, "floor.db")


def measured(run: Run) -> dict[str, dict[str, float]]:
    """CPU microseconds per event of each stage and implementation; the least of three passes, taken by turns."""
    messages, window = run.messages, run.load.window
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
