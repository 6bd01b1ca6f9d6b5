"""What one run of W is given and what it notes: when each thing came, was durable, took its first step, went on."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Protocol

import msgspec

from benchmarks.peers.lean import Lean

now_ns = time.perf_counter_ns


class Times:
    """Instants by entity, in nanoseconds of one clock."""

    def __init__(self) -> None:
        self.came: dict[str, int] = {}
        self.durable: dict[str, int] = {}
        self.stepped: dict[str, int] = {}
        self.read: dict[str, int] = {}
        self.resumed: dict[str, int] = {}


class Load(msgspec.Struct, frozen=True, kw_only=True):
    """How W is offered: as fast as it is taken (``rate`` 0) or at so many events a second whatever happens.

    ``group_s``: for how long an open-loop system may gather what it commits together; ``window``: how many messages a saturated
    one may take before it must have acknowledged the first. ``calls``: each treatment makes one outside call in its third step.
    """

    rate: float = 0.0
    group_s: float = 0.002
    window: int = 256
    full_sync: bool = False
    calls: bool = False


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
        self.messages = messages
        self.lean = lean
        self.workload = workload
        self.store = store
        self.load = load
        self.times = Times()
        self.finished_ns = 0
        self._acks = _appending(store / "acknowledged") if load.calls else None
        self._calls = _appending(store / "called") if load.calls else None

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

    def acknowledged(self) -> set[str]:
        """What the client was told of in earlier lives of this store: it does not offer that again."""
        path = self.store / "acknowledged"
        return set(path.read_text().split()) if path.exists() else set()

    def due(self, count: int) -> Iterator[int]:
        """When each of ``count`` events is offered, in nanoseconds from the start; open loop only."""
        step = 1e9 / self.load.rate
        return (round(number * step) for number in range(count))


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


def _appending(path: Path) -> int:
    return os.open(path, os.O_CREAT | os.O_WRONLY | os.O_APPEND, 0o600)
