"""Decisions and what they rest on: which automatic ones are still open to correction."""

from __future__ import annotations

from collections import OrderedDict
from heapq import heappop, heappush

import msgspec


class Stale(msgspec.Struct, frozen=True, kw_only=True):
    """A past automatic decision whose knowledge was contradicted while its outcome is still to come."""

    process: int
    event: str
    treatment: str
    because: str


class Made(msgspec.Struct, kw_only=True):
    """A decision as it was made, and what was concluded. ``closes_ns`` is None until then."""

    process: int
    event: str
    treatment: str
    mode: str
    rests_on: tuple[int, ...]
    criticality: int = 0
    label: str = ""
    closes_ns: int | None = None
    settled: bool = False
    """Judged or reopened: no longer open to correction."""


class Standing:
    """Decisions by process, and by the experiences that they rest on while they are open to correction.

    Settled ones are kept for the experience that is made of them, at most ``keep`` of them.
    """

    def __init__(self, keep: int) -> None:
        self._keep = keep
        self._made: dict[int, Made] = {}
        self._settled: OrderedDict[int, None] = OrderedDict()
        self._on: dict[int, set[int]] = {}
        self._closing: list[tuple[int, int]] = []

    def get(self, process: int) -> Made | None:
        """The decision of a process; None where it is unknown or forgotten."""
        return self._made.get(process)

    def decide(self, made: Made) -> None:
        """A decision was made, or superseded before its process concluded."""
        before = self._made.get(made.process)
        if before is None or before.closes_ns is None:
            self._made[made.process] = made

    def cover(self, made: Made) -> None:
        """The first decision of a new process."""
        self._made[made.process] = made

    def conclude(self, process: int, mode: str, label: str, closes_ns: int | None) -> None:
        """A process has its result: until ``closes_ns`` the world may contradict it."""
        made = self._made.get(process)
        if made is None:
            return
        made.mode, made.label = mode, label
        if closes_ns is None:
            self.settle(process)
            return
        made.closes_ns = closes_ns
        heappush(self._closing, (closes_ns, process))
        if mode == "auto":
            for experience in made.rests_on:
                users = self._on.get(experience)
                if users is None:
                    self._on[experience] = {process}
                else:
                    users.add(process)

    def drop(self, process: int) -> None:
        """A process ended without a result."""
        made = self._made.get(process)
        if made is not None and made.closes_ns is None and not made.settled:
            del self._made[process]

    def park(self, process: int) -> Made | None:
        """Give away what is known of a process without a result; ``cover`` takes it back."""
        made = self._made.get(process)
        return None if made is None or made.closes_ns is not None or made.settled else self._made.pop(process)

    def settle(self, process: int) -> None:
        """A decision is no longer open to correction."""
        made = self._made.get(process)
        if made is None or made.settled:
            return
        made.settled = True
        for experience in made.rests_on:
            users = self._on.get(experience)
            if users is not None:
                users.discard(process)
                if not users:
                    del self._on[experience]
        self._settled[process] = None
        if len(self._settled) > self._keep:
            oldest, _ = self._settled.popitem(last=False)
            del self._made[oldest]

    def let_close(self, now_ns: int) -> None:
        """Settle what was not judged although its window closed."""
        while self._closing and self._closing[0][0] < now_ns:
            _, process = heappop(self._closing)
            self.settle(process)

    def sharing(self, made: Made) -> list[tuple[Made, tuple[int, ...]]]:
        """The automatic decisions still open that forecast the same and rest on at least half of the same experiences,
        the most critical first, then the one whose window closes first."""
        shared: dict[int, list[int]] = {}
        for experience in made.rests_on:
            for process in self._on.get(experience, ()):
                shared.setdefault(process, []).append(experience)
        found = [
            (other, tuple(experiences))
            for process, experiences in shared.items()
            if process != made.process
            and (other := self._made[process]).label == made.label
            and other.event != made.event
            and 2 * len(experiences) >= min(len(other.rests_on), len(made.rests_on))
        ]
        return sorted(found, key=lambda pair: (-pair[0].criticality, pair[0].closes_ns or 0, pair[0].process))
