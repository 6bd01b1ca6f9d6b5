"""What falls due: ends of steps, limits of waits, and instants at which to settle anew, in order of (time, rank, process)."""

from __future__ import annotations

import enum
import heapq
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from wakeful.facts.lines import Asked
from wakeful.facts.processes import State
from wakeful.scheduling.process import Process
from wakeful.scheduling.process_set import ProcessSet

#: Instant, rank, process, number of its request.
_Entry: TypeAlias = tuple[int, int, int, int]


#: Fewer limits than that are not worth a sweep.
_FEW = 1_024


class Rank(enum.IntEnum):
    """What falls due at one instant, in this order."""

    STEP = 0
    LIMIT = 1
    TICK = 2


class Due(NamedTuple):
    """One entry; ``process`` and ``seq`` are 0 where they say nothing."""

    at_ns: int
    rank: Rank
    process: int = 0
    seq: int = 0


class Agenda:
    """Two heaps of instants: steps, which may be put off, and what passes by the clock. An entry that no longer holds (its
    process moved on) is passed over when its turn comes.

    Args:
        processes: by whose state an entry holds or not.
        step_ns: kernel time that one step takes.
        stir: told of each instant that is entered, so that nobody has to look while none is due.
    """

    def __init__(self, processes: ProcessSet, step_ns: int, stir: Callable[[int], None]) -> None:
        self._processes = processes
        self._step_ns = step_ns
        self._stir = stir
        self._steps: list[_Entry] = []
        self._limits: list[_Entry] = []
        self._tick_ns: int | None = None

    def begin_step(self, process: Process) -> None:
        """The holder of a slot begins its next step, unless it is within one."""
        if not process.stepping:
            process.stepping = True
            self._enter(self._step_ends_ns(process), Rank.STEP, process.id)

    def limit(self, pending: Asked) -> None:
        """Let the request's limit pass when it comes; nothing where it has none."""
        if pending.expires_ns is not None:
            self._enter(pending.expires_ns, Rank.LIMIT, pending.process, pending.seq)
            self._sweep()

    def settle_at(self, at_ns: int) -> None:
        """Settle at that instant whatever else falls due, unless that is to be done sooner anyway."""
        if self._tick_ns is None or at_ns < self._tick_ns:
            self._tick_ns = at_ns
            self._enter(at_ns, Rank.TICK)

    def next_ns(self) -> int | None:
        """When the next entry that holds is due."""
        step, limit = self._first(self._steps), self._first(self._limits)
        if step is None or (limit is not None and limit < step):
            step = limit
        return None if step is None else step[0]

    def passes_ns(self) -> int | None:
        """When the next limit passes, or is to be settled anew: however many steps that are due before it are put off."""
        limit = self._first(self._limits)
        return None if limit is None else limit[0]

    @property
    def step_next(self) -> bool:
        """Whether the first entry is a step's end."""
        return bool(self._steps) and (not self._limits or self._steps[0] < self._limits[0])

    def take(self, passing: bool = False) -> Due | None:
        """Take the first entry off; ``passing``: the first that is no step. None where it no longer holds."""
        entry = heapq.heappop(self._limits if passing or not self.step_next else self._steps)
        if not self._holds(entry):
            return None
        if entry[1] == Rank.TICK:
            self._tick_ns = None
        return Due(entry[0], Rank(entry[1]), entry[2], entry[3])

    def _sweep(self) -> None:
        """Forget limits that no longer hold, where most don't: what was answered long before its limit, and who is parked."""
        if len(self._limits) > 2 * self._processes.at_hand + _FEW:
            self._limits = list(dict.fromkeys(entry for entry in self._limits if self._holds(entry)))
            heapq.heapify(self._limits)

    def _enter(self, at_ns: int, rank: int, process: int = 0, seq: int = 0) -> None:
        heapq.heappush(self._steps if rank == Rank.STEP else self._limits, (at_ns, int(rank), process, seq))
        self._stir(at_ns)

    def _first(self, heap: list[_Entry]) -> _Entry | None:
        while heap:
            if self._holds(heap[0]):
                return heap[0]
            heapq.heappop(heap)
        return None

    def _holds(self, entry: _Entry) -> bool:
        at_ns, rank, number, seq = entry
        if rank == Rank.TICK:
            return self._tick_ns == at_ns
        process = self._processes.get(number)
        if process is None:
            return False
        if rank == Rank.STEP:
            return process.stepping and self._step_ends_ns(process) == at_ns
        return process.state is State.WAITING and process.awaits(seq)

    def _step_ends_ns(self, process: Process) -> int:
        return process.active_since_ns + (process.ran + 1) * self._step_ns
