"""The paper's policy: the runnable process of highest priority, ties first come first served, state kept (Sec. III-B)."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

from wakeful.contracts.policy import Pick
from wakeful.facts.decisions import Mode
from wakeful.facts.processes import ProcessView

_Key = tuple[int, int, int, int]


class SuspendResume:
    """Preemptive by priority; what is preempted keeps its state and goes on later.

    A heap with lazy deletion: each call costs O(log n).
    """

    name = "suspend_resume"

    def __init__(self) -> None:
        self._heap: list[_Key] = []
        self._keys: dict[int, _Key] = {}

    def runnable(self, view: ProcessView, now_ns: int) -> None:  # noqa: ARG002
        """It competes from now on."""
        key = (-view.criticality, -view.priority, view.arrived_ns, view.id)
        if self._keys.get(view.id) != key:
            self._keys[view.id] = key
            heapq.heappush(self._heap, key)

    def waiting(self, view: ProcessView, now_ns: int) -> None:
        """It does not compete while it waits."""
        self.gone(view.id, now_ns)

    def gone(self, process: int, now_ns: int) -> None:  # noqa: ARG002
        """It no longer competes; its heap entry is dropped when it comes up."""
        self._keys.pop(process, None)

    def ran_through(self, treatment: str, mode: Mode, kind: str, steps: int, now_ns: int) -> None:
        """Nothing to remember."""

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:  # noqa: ARG002
        """The ``slots`` first by (criticality, priority, arrival, id)."""
        chosen: list[_Key] = []
        while self._heap and len(chosen) < slots:
            key = heapq.heappop(self._heap)
            if self._keys.get(key[3]) == key and (not chosen or chosen[-1] != key):
                chosen.append(key)
        for key in chosen:
            heapq.heappush(self._heap, key)
        return Pick(tuple(key[3] for key in chosen))
