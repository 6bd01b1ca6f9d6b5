"""What nobody can beat in Experiment 2: a scheduler that knows every arrival and every delay in advance.

The bound is lexicographic: first as many critical deadlines as can be met, then as many completions as there can be when no
critical event is missed. Both numbers are upper bounds on any schedule of one slot and one unit of work a step that is
optimal in that order; a policy without foresight that reaches 98 % of them has little left to gain.

**Critical deadlines** are exact. Only critical events matter to them, since the rest can always be put off. A forward search
over the steps keeps, for every reachable state of the critical events that can still be met, the most deadlines met so far.
Two cuts lose nothing. An event that can no longer be met leaves the state: it could only take slots from others. No step is
left idle while an event in the state could use it: take an optimal schedule that idles in step t although event j could be worked
on; moving j's next unit to t leaves all other events untouched, and j's later units, its first unit and so its evidence come no
later than before.

**Completion** is a relaxation. In a schedule that completes the set S, every unit of an event that arrives in step s or later
lies in the steps from s to the last, H - 1; so for every s: the work of those events of S is at most H - s. All critical events
are in S, and no event whose evidence cannot come before the run's end is (it comes ``evidence_steps`` after the arrival at the
earliest). The largest S that meets these conditions is therefore at least as large as any that can be scheduled. Read backwards
in time, the conditions say that each event has the deadline H - arrival and all can start at 0: the largest such set with some
compulsory members is found by Moore's and Hodgson's algorithm with Sidney's extension (1973). Take events by deadline; whenever
the work taken exceeds a deadline, give up the largest that is not compulsory. Leaving deadlines and the order of an event's units
out of this only makes S larger, so the bound is sound, whichever deadlines the first stage met.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence

from wakeful.experiments.worlds.service_load import DRAIN_STEPS, NOMINAL_STEPS, Arrival
from wakeful.facts.values import Fact

_HORIZON = NOMINAL_STEPS + DRAIN_STEPS

#: (event, units left, the first step that its last unit may be done in; -1 before its first unit, 0 where it needs no evidence)
_Open = tuple[int, int, int]
_State = tuple[_Open, ...]


class Bound(Fact, frozen=True):
    """The most that a clairvoyant reaches on one world, as counts."""

    events: int
    critical: int
    deadlines: int
    criticals: int
    completions: int


def clairvoyant(world: Sequence[Arrival], horizon: int = _HORIZON) -> Bound:
    """The bound of one world over ``horizon`` steps.

    Returns:
        Bound: ``completions`` counts on every critical event being completed, late or not; where even that cannot be done
        (their own work exceeds the time left) it is the number of events that can be completed with them dropped last.
    """
    return Bound(
        events=len(world),
        critical=sum(arrival.critical for arrival in world),
        deadlines=most_deadlines(world, horizon),
        criticals=most_completions([arrival for arrival in world if arrival.critical], horizon, spare=True),
        completions=most_completions(world, horizon),
    )


def most_deadlines(world: Sequence[Arrival], horizon: int = _HORIZON) -> int:
    """The greatest number of critical deadlines that one slot can meet. Exact."""
    coming: dict[int, list[_Open]] = {}
    for event, arrival in enumerate(world):
        if arrival.deadline_steps is not None:
            coming.setdefault(arrival.step, []).append((event, arrival.work, 0 if arrival.evidence_steps is None else -1))
    states: dict[_State, int] = {(): 0}
    for step in range(horizon):
        fresh = tuple(coming.get(step, ()))
        reached: dict[_State, int] = {}
        for state, met in states.items():
            alive = tuple(each for each in (*state, *fresh) if _can_be_met(world, each, step, horizon))
            for after, gained in _moves(world, alive, step):
                if reached.get(after, -1) < met + gained:
                    reached[after] = met + gained
        states = reached
    return max(states.values())


def _can_be_met(world: Sequence[Arrival], event: _Open, step: int, horizon: int) -> bool:
    number, left, ready = event
    arrival = world[number]
    last = min(arrival.step + (arrival.deadline_steps or 0), horizon - 1)
    earliest = step + left - 1
    if ready == -1:
        earliest = max(earliest, step + (arrival.evidence_steps or 0))
    return max(earliest, ready) <= last


def _moves(world: Sequence[Arrival], alive: _State, step: int) -> Iterable[tuple[_State, int]]:
    """The states that one step of work leads to, and whether it met a deadline; unchanged if nobody can be worked on."""
    worked = False
    for place, (number, left, ready) in enumerate(alive):
        if left == 1 and ready > step:
            continue
        worked = True
        rest = alive[:place] + alive[place + 1 :]
        if left == 1:
            yield rest, 1
        else:
            begun = step + (world[number].evidence_steps or 0) if ready == -1 else ready
            yield (*alive[:place], (number, left - 1, begun), *alive[place + 1 :]), 0
    if not worked:
        yield alive, 0


def most_completions(world: Sequence[Arrival], horizon: int = _HORIZON, *, spare: bool = False) -> int:
    """No schedule that completes every critical event completes more than so many. A relaxation, see above.

    ``spare``: critical events may be left out as well; over the critical ones alone, it bounds how many of them can be completed.
    """
    can_end = [each for each in world if each.step + max(each.work - 1, each.evidence_steps or 0) < horizon]
    optional: list[int] = []
    taken = work = 0
    for arrival in sorted(can_end, key=lambda each: -each.step):
        taken, work = taken + 1, work + arrival.work
        if spare or not arrival.critical:
            heapq.heappush(optional, -arrival.work)
        while work > horizon - arrival.step and optional:
            taken, work = taken - 1, work + heapq.heappop(optional)
    return taken
