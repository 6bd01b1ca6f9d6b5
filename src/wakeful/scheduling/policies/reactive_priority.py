"""Baseline: the highest priority first, and what it interrupts is dropped (Sec. IV-A, Reactive Priority)."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

from wakeful.contracts.policy import Pick
from wakeful.facts.processes import ProcessView

_Key = tuple[int, int, int]


class ReactivePriority:
    """A strictly higher priority takes the slot and the interrupted process is abandoned; so is one that waits for
    evidence while anything else is ready. Only experiments allow it: the journal says ``abandoned``. O(log n) a call."""

    name = "reactive_priority"

    def __init__(self) -> None:
        self._heap: list[_Key] = []
        self._keys: dict[int, _Key] = {}
        self._begun: _Key | None = None

    def runnable(self, view: ProcessView, now_ns: int) -> None:  # noqa: ARG002
        """It competes from now on."""
        key = (-view.priority, view.arrived_ns, view.id)
        if self._keys.get(view.id) != key:
            self._keys[view.id] = key
            heapq.heappush(self._heap, key)

    def waiting(self, view: ProcessView, now_ns: int) -> None:  # noqa: ARG002
        """It does not compete; it is dropped as soon as somebody else is ready."""
        self._keys.pop(view.id, None)

    def gone(self, process: int, now_ns: int) -> None:  # noqa: ARG002
        """It no longer competes."""
        self._keys.pop(process, None)
        if self._begun is not None and self._begun[2] == process:
            self._begun = None

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:  # noqa: ARG002
        """The one that was begun, unless it waits or a strictly higher priority is ready: then that one, and it is dropped."""
        while self._heap and self._keys.get(self._heap[0][2]) != self._heap[0]:
            heapq.heappop(self._heap)
        if not self._heap:
            return Pick(())
        best, begun = self._heap[0], self._begun
        if begun is None:
            self._begun = best
            return Pick((best[2],))
        if begun[2] in self._keys and best[0] >= begun[0]:
            return Pick((begun[2],))
        self._begun = best
        return Pick((best[2],), abandon=(begun[2],))
