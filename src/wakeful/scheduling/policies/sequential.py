"""Baseline: first come, first served, and the slot is kept while evidence is waited for (Sec. IV-A, Sequential)."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

from wakeful.contracts.policy import Pick
from wakeful.facts.processes import ProcessView

_Key = tuple[int, int]


class Sequential:
    """Finishes, or waits on, the process that came first before it goes on to the next. One slot. O(log n) a call."""

    name = "sequential"

    def __init__(self) -> None:
        self._queue: list[_Key] = []
        self._queued: set[int] = set()
        self._runnable: dict[int, bool] = {}

    def serves(self, view: ProcessView) -> bool:  # noqa: ARG002
        """Whether a process is served at all: every one."""
        return True

    def runnable(self, view: ProcessView, now_ns: int) -> None:  # noqa: ARG002
        """It stands in the queue, ready."""
        self._stand(view, ready=True)

    def waiting(self, view: ProcessView, now_ns: int) -> None:  # noqa: ARG002
        """It keeps its place in the queue, not ready: if it is the first, everybody waits."""
        self._stand(view, ready=False)

    def _stand(self, view: ProcessView, *, ready: bool) -> None:
        if not self.serves(view):
            return
        self._runnable[view.id] = ready
        if view.id not in self._queued:
            self._queued.add(view.id)
            heapq.heappush(self._queue, (view.arrived_ns, view.id))

    def gone(self, process: int, now_ns: int) -> None:  # noqa: ARG002
        """It leaves the queue."""
        self._runnable.pop(process, None)

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:  # noqa: ARG002
        """The first of the queue if it is ready; nobody if it waits."""
        while self._queue and self._queue[0][1] not in self._runnable:
            self._queued.discard(heapq.heappop(self._queue)[1])
        if not self._queue or not self._runnable[self._queue[0][1]]:
            return Pick(())
        return Pick((self._queue[0][1],))
