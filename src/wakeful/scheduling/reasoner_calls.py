"""Who may ask the reasoner now: so many calls under way at once, the others in a queue, criticals first."""

from __future__ import annotations

import heapq

_Key = tuple[int, int, int, int]


class ReasonerCalls:
    """A fold over requests and answers, live and in recovery alike: the same records, the same calls under way since when.

    What is under way is never interrupted, since an answer is paid for once asked; what queues is taken by
    (criticality, priority, arrival, id). O(log n) a change.

    Args:
        slots: how many may be under way at once; 0: no limit.
    """

    def __init__(self, slots: int) -> None:
        self._slots = slots
        self._since_ns: dict[int, int] = {}
        self._queued: dict[int, _Key] = {}
        self._aside: dict[int, _Key] = {}
        self._heap: list[_Key] = []
        self._released: list[int] = []

    @property
    def queued(self) -> int:
        """How many wait for their turn, those that an operator holds among them."""
        return len(self._queued) + len(self._aside)

    @property
    def under_way(self) -> int:
        """How many are being answered."""
        return len(self._since_ns)

    def ask(self, process: int, key: tuple[int, int, int], now_ns: int, *, held: bool) -> None:
        """The process asks; ``key`` is (-criticality, -priority, arrival)."""
        place = (*key, process)
        if held:
            self._aside[process] = place
        else:
            self._stand(process, place)
        self._release(now_ns)

    def leave(self, process: int, now_ns: int) -> None:
        """It was answered, gave up, or is gone; whoever is next takes its place. Nothing where it did not ask."""
        self._queued.pop(process, None)
        self._aside.pop(process, None)
        if self._since_ns.pop(process, None) is not None:
            self._release(now_ns)

    def hold(self, process: int) -> None:
        """An operator holds it: it loses no place, but is passed over while it queues."""
        place = self._queued.pop(process, None)
        if place is not None:
            self._aside[process] = place

    def let_go(self, process: int, now_ns: int) -> None:
        """The operator lets it go on."""
        place = self._aside.pop(process, None)
        if place is not None:
            self._stand(process, place)
            self._release(now_ns)

    def is_under_way(self, process: int) -> bool:
        """Whether the process is being answered, rather than queued."""
        return process in self._since_ns

    def take(self) -> list[tuple[int, int]]:
        """The processes whose turn has come since this was asked last, in that order, and since when."""
        released, self._released = dict.fromkeys(self._released), []
        return [(each, self._since_ns[each]) for each in released if each in self._since_ns]

    def _stand(self, process: int, place: _Key) -> None:
        self._queued[process] = place
        heapq.heappush(self._heap, place)

    def _release(self, now_ns: int) -> None:
        while self._heap and (not self._slots or len(self._since_ns) < self._slots):
            place = heapq.heappop(self._heap)
            process = place[3]
            if self._queued.get(process) == place:
                del self._queued[process]
                self._since_ns[process] = now_ns
                self._released.append(process)
