"""What falls due: ends of steps, limits of waits, and instants at which to settle anew, in order of (time, rank, process)."""

from __future__ import annotations

import enum
import heapq

import msgspec

from wakeful.facts.lines import Asked
from wakeful.facts.processes import State
from wakeful.scheduling.process import Process
from wakeful.scheduling.process_set import ProcessSet


class Rank(enum.IntEnum):
    """What falls due at one instant, in this order."""

    STEP = 0
    LIMIT = 1
    TICK = 2


class Due(msgspec.Struct, frozen=True, order=True):
    """One entry; ``process`` and ``seq`` are 0 where they say nothing."""

    at_ns: int
    rank: Rank
    process: int = 0
    seq: int = 0


class Agenda:
    """A heap of instants. An entry that no longer holds (its process moved on) is passed over when its turn comes.

    Args:
        processes: by whose state an entry holds or not.
        step_ns: kernel time that one step takes.
    """

    def __init__(self, processes: ProcessSet, step_ns: int) -> None:
        self._processes = processes
        self._step_ns = step_ns
        self._heap: list[Due] = []
        self._tick_ns: int | None = None

    def begin_step(self, process: Process) -> None:
        """The holder of a slot begins its next step, unless it is within one."""
        if not process.stepping:
            process.stepping = True
            heapq.heappush(self._heap, Due(self._step_ends_ns(process), Rank.STEP, process.id))

    def limit(self, pending: Asked) -> None:
        """Let the request's limit pass when it comes; nothing where it has none."""
        if pending.expires_ns is not None:
            heapq.heappush(self._heap, Due(pending.expires_ns, Rank.LIMIT, pending.process, pending.seq))

    def settle_at(self, at_ns: int) -> None:
        """Settle at that instant whatever else falls due, unless that is to be done sooner anyway."""
        if self._tick_ns is None or at_ns < self._tick_ns:
            self._tick_ns = at_ns
            heapq.heappush(self._heap, Due(at_ns, Rank.TICK))

    def next_ns(self) -> int | None:
        """When the next entry that holds is due."""
        while self._heap:
            if self._holds(self._heap[0]):
                return self._heap[0].at_ns
            heapq.heappop(self._heap)
        return None

    def take(self) -> Due | None:
        """Take the first entry off; None where it no longer holds."""
        due = heapq.heappop(self._heap)
        if not self._holds(due):
            return None
        if due.rank is Rank.TICK:
            self._tick_ns = None
        return due

    def _holds(self, due: Due) -> bool:
        if due.rank is Rank.TICK:
            return self._tick_ns == due.at_ns
        process = self._processes.get(due.process)
        if process is None:
            return False
        if due.rank is Rank.STEP:
            return process.stepping and self._step_ends_ns(process) == due.at_ns
        pending = process.pending
        return process.state is State.WAITING and pending is not None and pending.seq == due.seq

    def _step_ends_ns(self, process: Process) -> int:
        return process.active_since_ns + (process.ran + 1) * self._step_ns
