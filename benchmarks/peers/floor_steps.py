"""The floor's last stage: for each step one heap operation and one resumption of a coroutine or generator."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Coroutine, Generator, Iterator
from types import coroutine

from benchmarks.peers.messages import Event
from benchmarks.peers.running import now_ns
from benchmarks.peers.treating import LIMIT_NS, WAITS, conclude, look, weigh


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
