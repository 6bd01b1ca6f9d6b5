"""wakeful's own policy, and its default: deadlines that can be met, then late criticals, then as many completions as can be.

Preemptive, and what is preempted keeps its state. It knows neither the future nor a horizon, and where a process doesn't say
how many steps it needs, it goes by how many such processes needed before. In this order the slots go to:

1. Critical processes that will have to wait for something and have not begun, while the deadlines of the others leave room for
   one step: what they wait for comes the sooner the sooner they begin.
2. Critical processes whose deadlines can be met: the earliest deadline first, over the largest set of them that fits (Moore and
   Hodgson 1968); those whose waits may still come too late give way first.
3. Critical processes that are late: first come, first served, for a late answer is better than none.
4. The same as 2 among the other processes that have a deadline.
5. Processes that will have to wait and have not begun, while everything else that is ready takes less time than they will wait.
6. The rest: the least work left first, so that as many as possible are completed. Waiting counts for it: ``wait_s_per_step``
   seconds make up for one step more. So a process with w steps left is overtaken only by those that come within
   (w - 1) × ``wait_s_per_step`` seconds after it, and by critical ones: nothing starves.

Its answer is a function of what it was told and of the time, never of earlier answers: a recovered mind decides as if it had
not been interrupted. Each call costs O(log n); the set in 2 is looked for among the ``considered`` earliest deadlines only.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

import msgspec

from wakeful.contracts.policy import Pick
from wakeful.facts.decisions import Mode
from wakeful.facts.events import CRITICAL
from wakeful.facts.processes import ProcessView
from wakeful.facts.time import to_ns
from wakeful.scheduling.policies.effort import STEP, History

_Key = tuple[int, int, int]


class DeadlineAwareSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What may be set.

    ``wait_s_per_step``: seconds of waiting that make up for one step more of work left. ``head_start_steps``: what each level of
    criticality below critical counts for, in the same coin. ``assumed_steps``: what a process is taken to need before any
    was completed. ``considered``: among how many of the earliest deadlines the set that can be met is looked for;
    ``looked_at``: how far that search may go past deadlines that can't be met any more.
    """

    wait_s_per_step: float = 160.0
    head_start_steps: float = 4.0
    assumed_steps: int = 4
    considered: int = 32
    looked_at: int = 256


class _Ready(msgspec.Struct):
    """A process that can use a slot, and what is expected of it as of when it was last told of."""

    view: ProcessView
    left: int
    """Thousandths of a step."""
    least: int
    opens: bool
    """It has not begun and will wait."""
    pending: bool
    """What it will wait for has not come."""
    rank: _Key


class _Queue:
    """Ready processes in the order of a key; changed keys are dropped when they come up."""

    def __init__(self) -> None:
        self._heap: list[_Key] = []
        self._keys: dict[int, _Key] = {}

    def put(self, key: _Key) -> None:
        """Let the process ``key[2]`` stand at ``key`` from now on."""
        if self._keys.get(key[2]) != key:
            self._keys[key[2]] = key
            heapq.heappush(self._heap, key)

    def drop(self, process: int) -> None:
        """Take the process out."""
        self._keys.pop(process, None)

    def first(self, limit: int) -> list[int]:
        """The first ``limit`` processes in order, which stay in the queue."""
        found: list[_Key] = []
        while self._heap and len(found) < limit:
            key = heapq.heappop(self._heap)
            if self._keys.get(key[2]) == key and (not found or found[-1] != key):
                found.append(key)
        for key in found:
            heapq.heappush(self._heap, key)
        return [key[2] for key in found]


class DeadlineAware:
    """See the module. Ties go by arrival, then id.

    Args:
        settings: the documented defaults where None.
    """

    name = "deadline_aware"

    def __init__(self, settings: DeadlineAwareSettings | None = None) -> None:
        self.settings = settings if settings is not None else DeadlineAwareSettings()
        self._history = History(self.settings.assumed_steps)
        self._wait_ns_per_step = max(1, to_ns(self.settings.wait_s_per_step))
        self._ready: dict[int, _Ready] = {}
        self._waiting: set[int] = set()
        self._before_wait: dict[int, int] = {}
        self._came: set[int] = set()
        self._critical_deadlines, self._other_deadlines = _Queue(), _Queue()
        self._criticals, self._openings, self._rest = _Queue(), _Queue(), _Queue()
        self._rest_left = 0

    # --- what it is told ---

    def runnable(self, view: ProcessView, now_ns: int) -> None:
        """It competes from now on, with what is left of it as far as anybody knows."""
        self._history.advance(now_ns)
        if view.id in self._waiting:
            self._waiting.discard(view.id)
            if view.id not in self._came:
                self._came.add(view.id)
                self._history.woke(view, now_ns)
        self._stand(view)

    def waiting(self, view: ProcessView, now_ns: int) -> None:
        """It does not compete while it waits."""
        self._leave(view.id)
        self._waiting.add(view.id)
        if view.id not in self._before_wait:
            self._before_wait[view.id] = view.steps_done
            self._history.waits(view, now_ns)

    def completed(self, view: ProcessView, now_ns: int) -> None:
        """How many steps it took in the end."""
        self._history.completed(view, self._before_wait.get(view.id), now_ns)

    def ran_through(self, treatment: str, mode: Mode, kind: str, steps: int, now_ns: int) -> None:
        """How many steps it took: there is nobody whom it could have kept waiting."""
        self._history.ran_through((treatment, mode, kind), steps, now_ns)

    def gone(self, process: int, now_ns: int) -> None:  # noqa: ARG002
        """It no longer competes."""
        self._leave(process)
        self._waiting.discard(process)
        self._before_wait.pop(process, None)
        self._came.discard(process)

    def park(self, process: int) -> tuple[int, ...]:
        """Its steps before it waited for the first time, and whether that wait is over; it is forgotten."""
        known = (self._before_wait.pop(process, -1), int(process in self._came))
        self._waiting.discard(process)
        self._came.discard(process)
        return known

    def bring_back(self, process: int, known: tuple[int, ...]) -> None:
        """It waits as before."""
        before_wait, came = known
        self._waiting.add(process)
        if before_wait >= 0:
            self._before_wait[process] = before_wait
        if came:
            self._came.add(process)

    def _stand(self, view: ProcessView) -> None:
        effort = self._history.of(view)
        came = view.id in self._came
        if view.steps_needed is not None:
            left = least = max(1, view.steps_needed - view.steps_done) * STEP
        elif came:
            left = least = effort.left_after_wait(view.steps_done)
        else:
            left, least = effort.left(view.steps_done), effort.least_left(view.steps_done)
        waits = view.needs_evidence if view.needs_evidence is not None else effort.likely_waits()
        pending = waits and not came
        ready = _Ready(
            view=view,
            left=left,
            least=least,
            opens=pending and view.started_ns is None,
            pending=pending,
            rank=self._rank(view, left),
        )
        self._leave(view.id)
        self._ready[view.id] = ready
        came_first = (view.arrived_ns, 0, view.id)
        if view.criticality >= CRITICAL:
            self._criticals.put(came_first)
            if view.deadline_ns is not None:
                self._critical_deadlines.put((view.deadline_ns, view.arrived_ns, view.id))
            return
        self._rest.put(ready.rank)
        self._rest_left += left
        if ready.opens:
            self._openings.put(came_first)
        if view.deadline_ns is not None:
            self._other_deadlines.put((view.deadline_ns, view.arrived_ns, view.id))

    def _rank(self, view: ProcessView, left: int) -> _Key:
        head_start = round(view.criticality * self.settings.head_start_steps * STEP)
        return left - head_start + view.arrived_ns * STEP // self._wait_ns_per_step, view.arrived_ns, view.id

    def _leave(self, process: int) -> None:
        ready = self._ready.pop(process, None)
        if ready is None:
            return
        if ready.view.criticality < CRITICAL:
            self._rest_left -= ready.left
        for queue in (self._critical_deadlines, self._other_deadlines, self._criticals, self._openings, self._rest):
            queue.drop(process)

    # --- what it answers ---

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:
        """The processes for the next step, in the order of the module's list."""
        self._history.advance(now_ns)
        for process in running:
            if process in self._ready:
                self._stand(self._ready[process].view)  # by what was learned since it was last told of
        chosen: dict[int, None] = {}
        for process in self._in_order(slots, now_ns):
            chosen[process] = None
            if len(chosen) == slots:
                break
        return Pick(tuple(chosen))

    def _in_order(self, slots: int, now_ns: int) -> Iterator[int]:
        yield from self._in_time(self._critical_deadlines, slots, now_ns)
        yield from self._criticals.first(slots * 2)
        yield from self._in_time(self._other_deadlines, slots, now_ns)
        yield from self._worth_opening(slots)
        yield from self._rest.first(slots * 2)

    def _in_time(self, queue: _Queue, slots: int, now_ns: int) -> Iterator[int]:
        """First those that should begin at once, then the largest set whose deadlines can be met, earliest first."""
        step_ns = self._history.step_ns
        firm: list[_Candidate] = []
        pending: list[_Candidate] = []
        for process in self._earliest(queue, now_ns):
            ready = self._ready[process]
            room_ns = (ready.view.deadline_ns or 0) - now_ns
            if ready.least * step_ns <= room_ns * STEP:
                # What is only expected to take too long may still turn out short enough: it counts for the time there is.
                work_ns = min(ready.left * step_ns // STEP, room_ns)
                candidate = _Candidate(room_ns, ready.view.arrived_ns, process, work_ns, ready.pending, ready.opens)
                (pending if ready.pending else firm).append(candidate)
        sure, spare_ns = _largest_set(firm, slots)
        opening = sorted(each for each in pending if each.opens)
        yield from (each.process for each in (opening[: spare_ns // step_ns] if sure and step_ns else opening))
        met, _ = _largest_set(sorted([*sure, *pending]), slots)
        yield from (each.process for each in met)

    def _earliest(self, queue: _Queue, now_ns: int) -> list[int]:
        """The earliest deadlines that are not past; further ones too where too many of them can't be met, so that a burst of
        hopeless ones hides none that can."""
        step_ns = self._history.step_ns
        found: list[int] = []
        for limit in (self.settings.considered, self.settings.looked_at):
            found = queue.first(limit)
            rooms = [((self._ready[each].view.deadline_ns or 0) - now_ns, self._ready[each].least) for each in found]
            possible = sum(room_ns > 0 and least * step_ns <= room_ns * STEP for room_ns, least in rooms)
            if possible == limit or len(found) < limit or possible > limit // 2:
                break
        for process, (room_ns, _) in zip(found, rooms, strict=True):
            if room_ns <= 0:
                queue.drop(process)
        return [process for process, (room_ns, _) in zip(found, rooms, strict=True) if room_ns > 0]

    def _worth_opening(self, slots: int) -> Iterator[int]:
        backlog_ns = self._rest_left * self._history.step_ns // (STEP * slots)
        for process in self._openings.first(slots):
            wait_ns = self._history.of(self._ready[process].view).longest_wait_ns
            if wait_ns is None or backlog_ns <= wait_ns:
                yield process


class _Candidate(NamedTuple):
    """A process whose deadline may be met, in the order of deadlines."""

    room_ns: int
    arrived_ns: int
    process: int
    work_ns: int
    pending: bool
    opens: bool


def _largest_set(candidates: Sequence[_Candidate], slots: int) -> tuple[list[_Candidate], int]:
    """The largest set, in the order given (by deadline), in which each can be done by its deadline, and the time to spare in it.

    Moore and Hodgson's algorithm: whenever one would be late, the longest up to it gives way; of those whose waits may come too
    late one that has not begun first, then one that has. With several slots the work is taken to spread evenly over them.
    """
    dropped: set[int] = set()
    longest: list[tuple[bool, bool, int, int]] = []
    work_ns = 0
    for each in candidates:
        heapq.heappush(longest, (not each.pending, not each.opens, -each.work_ns, each.process))
        work_ns += each.work_ns
        while work_ns > slots * each.room_ns:
            _, _, less_ns, process = heapq.heappop(longest)
            work_ns += less_ns
            dropped.add(process)
    kept = [each for each in candidates if each.process not in dropped]
    before_ns = accumulate(each.work_ns for each in kept)
    spare_ns = min((slots * each.room_ns - done_ns for each, done_ns in zip(kept, before_ns, strict=True)), default=0)
    return kept, spare_ns
