"""What one scheduling decision costs, from 100 to 1,000,000 open processes, beside a bare heapq push and pop on as many keys.

Run: `python benchmarks/scheduling.py [LARGEST]`. One decision is: the policy hears that the holder of the slot has done a step,
every fourth time that it is resolved and that another process came, and picks the next holder. `process set` is the same
through the records of the kernel's process table. Prints the median and the range from the 10th to the 90th percentile in
microseconds, and the median as a ratio to heapq's in the same run. Logarithmic growth shows as rows that barely differ.
"""

from __future__ import annotations

import gc
import heapq
import sys
import time
from collections.abc import Callable
from random import Random
from statistics import median, quantiles

import msgspec

from wakeful.contracts.policy import LearningPolicy, Policy
from wakeful.facts.decisions import Candidate, Decision, Gate
from wakeful.facts.events import Context, Event
from wakeful.facts.lines import Created, Decided, Moved
from wakeful.facts.processes import ProcessView, State, Trigger
from wakeful.facts.time import NS_PER_S, Stamp
from wakeful.scheduling.policies.deadline_aware import DeadlineAware
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.scheduling.process_set import ProcessSet

DECISIONS = 2_000
SIZES = (100, 1_000, 10_000, 100_000, 1_000_000)


def view(number: int, random: Random, now_ns: int) -> ProcessView:
    """A seeded process: three in ten critical, with deadlines that a backlog of this size can partly meet."""
    critical = random.random() < 0.3
    return ProcessView(
        id=number,
        event=f"e{number}",
        treatment="paced",
        mode="auto",
        criticality=3 if critical else random.randrange(3),
        arrived_ns=now_ns,
        steps_done=0,
        priority=random.randrange(6),
        deadline_ns=now_ns + random.randint(5, 100_000) * NS_PER_S if critical else None,
        steps_needed=random.randint(3, 6),
        kind="k",
        needs_evidence=random.random() < 0.3,
    )


class PolicyAlone:
    """The policy, told of everything as the kernel would tell it."""

    def __init__(self, policy: Policy, size: int) -> None:
        self.policy = policy
        self.random = Random(size)
        self.views: dict[int, ProcessView] = {}
        self.now_ns = 0
        self.made = 0
        self.running: tuple[int, ...] = ()
        for _ in range(size):
            self._come()
        self.running = policy.pick((), 1, self.now_ns).run

    def _come(self) -> None:
        self.made += 1
        found = self.views[self.made] = view(self.made, self.random, self.now_ns)
        self.policy.runnable(found, self.now_ns)

    def decide(self) -> None:
        """One step's end and the next decision."""
        self.now_ns += NS_PER_S
        holder = self.running[0]
        held = self.views[holder]
        steps = held.steps_done + 1
        started_ns = held.started_ns if held.started_ns is not None else self.now_ns - NS_PER_S
        done = msgspec.structs.replace(held, steps_done=steps, started_ns=started_ns, spent_ns=steps * NS_PER_S)
        if steps == done.steps_needed:
            del self.views[holder]
            if isinstance(self.policy, LearningPolicy):
                self.policy.completed(done, self.now_ns)
            self.policy.gone(holder, self.now_ns)
            self._come()
        else:
            self.views[holder] = done
            self.policy.runnable(done, self.now_ns)
        self.running = self.policy.pick(self.running, 1, self.now_ns).run


DECISION = Decision(
    treatment="paced",
    mode="auto",
    confidence=1.0,
    candidates=(Candidate(treatment="paced", probability=1.0),),
    reasons=(),
    gate=Gate(confidence=1, threshold=0, novelty=0, novelty_limit=1, trust=1, trust_limit=0),
)


class WholeSet:
    """The process set and its policy: every transition as a record."""

    def __init__(self, policy: Policy, size: int) -> None:
        self.random = Random(size)
        self.events: dict[str, Event] = {}
        self.set = ProcessSet(policy, lambda name: self.events[name])
        self.now_ns = 0
        for _ in range(size):
            self._come()

    def _come(self) -> None:
        number = self.set.next_id
        made = view(number, self.random, self.now_ns)
        fields = {"steps_needed": made.steps_needed, "needs_evidence": made.needs_evidence, "priority": made.priority}
        event = Event(
            id=made.event,
            kind="k",
            entity="e",
            source="s",
            position=number,
            stamp=Stamp(source_ns=self.now_ns),
            context=Context(task="t", fields=fields),
            criticality=made.criticality,  # type: ignore[arg-type]
        )
        self.events[event.id] = event
        self.set.apply(
            Created(
                process=number, event=event.id, treatment="paced", criticality=made.criticality, deadline_ns=made.deadline_ns
            ),
            self.now_ns,
        )
        self.set.apply(Decided(process=number, event=event.id, decision=DECISION), self.now_ns)

    def decide(self) -> None:
        """One step's end and the next decision: preemption, completion and arrival as the kernel records them."""
        self.now_ns += NS_PER_S
        holder = self.set[self.set.active[0]] if self.set.active else None
        if holder is not None:
            holder.ran += 1
            steps = holder.steps + holder.ran
            if steps >= (holder.view().steps_needed or 1):
                del self.events[holder.event.id]
                self._move(holder.id, State.ACTIVE, Trigger.RESOLVE, State.COMPLETED, steps)
                self._come()
                holder = None
            else:
                self.set.stepped(holder, self.now_ns)
        chosen = self.set.policy.pick(self.set.active, 1, self.now_ns).run[0]
        if holder is not None and holder.id != chosen:
            self._move(holder.id, State.ACTIVE, Trigger.PREEMPT, State.SUSPENDED, holder.steps + holder.ran)
        if holder is None or holder.id != chosen:
            found = self.set[chosen]
            self._move(chosen, found.state, Trigger.DISPATCH, State.ACTIVE, found.steps)

    def _move(self, process: int, before: State, trigger: Trigger, after: State, steps: int) -> None:
        self.set.apply(Moved(process=process, before=before, trigger=trigger, after=after, steps=steps), self.now_ns)


class Bare:
    """The floor: a heap of as many keys, one push and one pop."""

    def __init__(self, size: int) -> None:
        self.random = Random(size)
        self.heap = [(self.random.random(), number) for number in range(size)]
        heapq.heapify(self.heap)

    def decide(self) -> None:
        """One push and one pop."""
        heapq.heappush(self.heap, (self.random.random(), 0))
        heapq.heappop(self.heap)


SUBJECTS: tuple[tuple[str, Callable[[int], PolicyAlone | WholeSet | Bare]], ...] = (
    ("heapq push and pop", Bare),
    ("suspend_resume alone", lambda size: PolicyAlone(SuspendResume(), size)),
    ("deadline_aware alone", lambda size: PolicyAlone(DeadlineAware(), size)),
    ("deadline_aware, process set", lambda size: WholeSet(DeadlineAware(), size)),
)


def main(largest: int) -> None:
    """Measure each size and print the table."""
    print(f"{'open processes':>14}  {'one decision':28} {'median µs':>10} {'p10 .. p90 µs':>18} {'to heapq':>9}")
    for size in (each for each in SIZES if each <= largest):
        floor = 0.0
        for name, make in SUBJECTS:
            subject = make(size)
            gc.collect()
            gc.disable()
            times: list[float] = []
            for _ in range(DECISIONS):
                began = time.perf_counter_ns()
                subject.decide()
                times.append((time.perf_counter_ns() - began) / 1000)
            gc.enable()
            cuts = quantiles(times, n=10)
            floor = floor or median(times)
            spread = f"{cuts[0]:.1f} .. {cuts[-1]:.1f}"
            print(f"{size:14,}  {name:28} {median(times):10.1f} {spread:>18} {median(times) / floor:9.1f}", flush=True)
            del subject


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else SIZES[-1])
