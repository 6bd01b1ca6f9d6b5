"""What one run of W is given and what it notes: when each thing came, was durable, took its first step, went on."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Protocol

import msgspec

from benchmarks.peers.lean import Lean
from benchmarks.peers.messages import AnyMessage, decode

now_ns = time.perf_counter_ns

#: Workload time between two events.
SPACING_NS = 10_000_000

_CURSOR = "cursor"


class Times:
    """Instants by entity, in nanoseconds of one clock."""

    def __init__(self) -> None:
        self.came: dict[str, int] = {}
        self.durable: dict[str, int] = {}
        self.stepped: dict[str, int] = {}
        self.read: dict[str, int] = {}
        self.resumed: dict[str, int] = {}
        self.treated = 0


class Load(msgspec.Struct, frozen=True, kw_only=True):
    """How W is offered: as fast as it is taken (``rate`` 0) or at so many events a second whatever happens.

    ``group_s``: for how long an open-loop system may gather what it commits together; ``window``: how many messages a saturated
    one is handed at once. ``full_sync``: an acknowledgement survives power loss too. ``calls``: each treatment makes one outside
    call, and the client writes down what was acknowledged. ``outcomes``: without them it is seen what they take of the journal.
    """

    rate: float = 0.0
    group_s: float = 0.002
    window: int = 256
    full_sync: bool = False
    calls: bool = False
    outcomes: bool = True


class Run:
    """One run of W by one system.

    Args:
        messages: the bytes that arrive, in order.
        lean: the model; wakeful has the same as a published version.
        workload: the folder with the card and weights.
        store: an own folder for what the system keeps.
        load: how it is offered.
    """

    def __init__(self, messages: list[bytes], lean: Lean, workload: Path, store: Path, load: Load) -> None:
        self.messages = messages if load.outcomes else [text for text in messages if b'"is":"outcome"' not in text]
        self.lean = lean
        self.workload = workload
        self.store = store
        self.load = load
        self.times = Times()
        self.restarted = (store / "acknowledged").exists()
        self.acknowledged, self.cursor = _remembered(store / "acknowledged")
        self._acks = _appending(store / "acknowledged") if load.calls else None
        self._calls = _appending(store / "called") if load.calls else None
        self._due = _offsets(self.messages, load.rate) if load.rate else []

    def windows(self, *, sleep: bool = True) -> Iterator[tuple[list[int], list[bytes]]]:
        """What arrives, and when it did: up to a window at once, or (open loop) what has become due within a group's time.

        Whoever asks for the next window says that all of this one is durable, so far as it ever is. ``sleep``: between two
        windows of an open loop; a system with an event loop sleeps by itself.
        """
        return self._open_loop(sleep) if self.load.rate else self._saturated()

    def _saturated(self) -> Iterator[tuple[list[int], list[bytes]]]:
        for begin in range(self.cursor, len(self.messages), self.load.window):
            texts = self.messages[begin : begin + self.load.window]
            yield [now_ns()] * len(texts), texts
            self.passed(begin + len(texts))

    def _open_loop(self, sleep: bool) -> Iterator[tuple[list[int], list[bytes]]]:
        start_ns, at = now_ns(), 0
        due = [start_ns + offset for offset in self._due]
        while at < len(due):
            until, until_ns = at, now_ns()
            while until < len(due) and due[until] <= until_ns:
                until += 1
            yield due[at:until], self.messages[at:until]
            at = until
            if sleep:
                time.sleep(self.load.group_s)

    def passed(self, position: int) -> None:
        """The client need not send again what lies before this position."""
        if self._acks is not None:
            os.write(self._acks, f"{_CURSOR} {position}\n".encode())

    def before(self) -> list[AnyMessage]:
        """What was sent in earlier lives of this store, for a system whose memory must be built again."""
        return [decode(text) for text in self.messages[: self.cursor]]

    def acknowledge(self, entities: Iterable[str]) -> None:
        """The client hears that these events are durable; where crashes are counted, it writes that down."""
        at, durable = now_ns(), self.times.durable
        for entity in entities:
            durable[entity] = at
        if self._acks is not None:
            os.write(self._acks, "".join(f"{entity}\n" for entity in entities).encode())

    def call(self, entity: str) -> int:
        """The outside call: the callee counts it, in a file of its own that only grows."""
        if self._calls is None:
            return 0
        os.write(self._calls, f"{entity}\n".encode())
        return 1


class System(Protocol):
    """One way to run W. Made (not measured), run (measured), asked what it came to (not measured)."""

    def run(self) -> None:
        """Take all messages, and return when every event has its outcome recorded and is durable where that is meant."""

    def finals(self) -> list[str]:
        """Each event's final state, read from where the system keeps it."""

    def stored_bytes(self) -> int:
        """What the system has written that it keeps."""


def size_of(folder: Path, *prefixes: str) -> int:
    """The bytes of the files in a folder whose names begin so."""
    return sum(path.stat().st_size for path in folder.iterdir() if path.name.startswith(prefixes))


def _offsets(messages: list[bytes], rate: float) -> list[int]:
    """When each message is offered, in nanoseconds from the start: workload time, run so fast that events come at that rate."""
    at = [decode(text).at_ns for text in messages]
    faster = rate * SPACING_NS / 1e9
    return [round((each - at[0]) / faster) for each in at]


def _appending(path: Path) -> int:
    return os.open(path, os.O_CREAT | os.O_WRONLY | os.O_APPEND, 0o600)


def _remembered(path: Path) -> tuple[set[str], int]:
    """Which events were acknowledged, and from where on messages must be sent again."""
    entities: set[str] = set()
    cursor = 0
    for line in path.read_text().splitlines() if path.exists() else ():
        word, _, number = line.partition(" ")
        if word == _CURSOR:
            cursor = int(number)
        else:
            entities.add(word)
    return entities, cursor
