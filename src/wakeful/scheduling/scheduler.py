"""The scheduler: gives slots to processes step by step, answers what they ask, and never loses one (Sec. III-B)."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import Protocol

import msgspec

from wakeful.contracts.policy import Policy
from wakeful.contracts.treatment import Treatment
from wakeful.facts.asking import Episode, Kind, Query, Reply
from wakeful.facts.decisions import Decision
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Act, Answer, Call
from wakeful.facts.lines import Acted, Answered, AnyRecord, Asked, Concluded, Created, Decided, Moved
from wakeful.facts.processes import State, Trigger, after
from wakeful.facts.results import Result, Unresolved
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import LONGEST_S, to_ns
from wakeful.facts.values import NOTHING, Raw
from wakeful.scheduling.driving import EXPIRED, Coroutines, Failure, Mismatch, Step, objection
from wakeful.scheduling.evidence import EvidenceShelf
from wakeful.scheduling.process import Process
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.thinking import WHICH_TREATMENT, provisional, revised
from wakeful.scheduling.wants import Want, Work

_STEP, _LIMIT, _TICK = 0, 1, 2
_OUTSIDE = (Kind.DELIBERATE, Kind.ASK, Kind.CALL)

#: The acts that need an open process.
ON_OPEN = ("hold", "release", "cancel")

#: What an Answered says in ``error`` when a call with effect was in doubt after a crash: a person is told, it is never retried.
IN_DOUBT = "in doubt after a crash: a call with effect is never made again"


class Host(Protocol):
    """What the scheduler needs of the kernel."""

    settings: MindSettings

    @property
    def now_ns(self) -> int: ...
    def write(self, record: AnyRecord) -> None: ...
    def event(self, identity: str) -> Event: ...
    def call(self, call: Call) -> None: ...
    def recall(self, query: Query) -> tuple[Episode, ...]: ...
    def closes_ns(self, arrived_ns: int) -> int: ...
    def counselled(self, decision: Decision, reply: Reply) -> dict[str, float]: ...
    def concluded(self, record: Concluded) -> None: ...
    def note(self, what: str, detail: str, process: int = 0, event: str = "") -> None: ...


class Treatments(Protocol):
    """Where treatments are found by name."""

    def get(self, name: str) -> Treatment: ...


class Scheduler:
    """Runs the process set. All its decisions are recorded through the host before they hold.

    Args:
        host: the kernel.
        policy: chooses among ready processes.
        treatments: where treatments are found.
        spec: the domain's data.
        options: the treatments among which deliberation may choose.
        shelf: evidence kept for who asks later.
    """

    def __init__(
        self,
        host: Host,
        policy: Policy,
        treatments: Treatments,
        spec: DomainSpec,
        options: tuple[str, ...],
        shelf: EvidenceShelf,
    ) -> None:
        self._host = host
        self._policy = policy
        self._slots = host.settings.slots
        self._step_ns = to_ns(host.settings.step_s)
        self.shelf = shelf
        self.processes = ProcessSet(policy, host.event, host.settings.reasoner_slots)
        self._coroutines = Coroutines(treatments.get, spec, options)
        self._due: list[tuple[int, int, int, int]] = []
        self._tick_ns: int | None = None

    # --- processes come ---

    def create(self, event: Event, decision: Decision, *, deadline_ns: int | None, reopens: int = 0, parent: int = 0) -> int:
        """Give the event a process with its decision, at this instant; returns the process's id."""
        process = self.processes.next_id
        self._host.write(
            Created(
                process=process,
                event=event.id,
                treatment=decision.treatment,
                criticality=event.criticality,
                parent=parent,
                reopens=reopens,
                deadline_ns=deadline_ns,
            )
        )
        self._host.write(Decided(process=process, event=event.id, decision=decision))
        self._settle()
        return process

    def result(self, concluded: Concluded) -> Result:
        """A recorded result in its treatment's own type."""
        return self._coroutines.result(concluded.treatment, concluded.result)

    # --- time ---

    def next_due_ns(self) -> int | None:
        """When the next step ends or the next limit passes."""
        while self._due:
            due_ns, rank, process, seq = self._due[0]
            if self._still_due(rank, process, seq, due_ns):
                return due_ns
            heapq.heappop(self._due)
        return None

    def run_due(self) -> None:
        """Do the first thing that is due: end one step, or let one limit pass."""
        due_ns, rank, identity, seq = heapq.heappop(self._due)
        if not self._still_due(rank, identity, seq, due_ns):
            return
        if rank == _TICK:
            self._tick_ns = None
            self._settle()
            return
        process = self.processes[identity]
        if rank == _STEP:
            self._step_ended(process)
        else:
            self._limit_passed(process)
        self._settle()

    def _still_due(self, rank: int, identity: int, seq: int, due_ns: int) -> bool:
        if rank == _TICK:
            return self._tick_ns == due_ns
        process = self.processes.get(identity)
        if process is None:
            return False
        if rank == _STEP:
            return process.stepping and process.active_since_ns + (process.ran + 1) * self._step_ns == due_ns
        pending = process.pending
        return process.state is State.WAITING and pending is not None and pending.seq == seq

    def _step_ended(self, process: Process) -> None:
        process.stepping = False
        process.ran += 1
        self.processes.stepped(process, self._host.now_ns)
        if isinstance(process.want, Work):
            process.want.left -= 1
            if process.want.left <= 0:
                self._resume(process)

    def _limit_passed(self, process: Process) -> None:
        pending = process.pending
        if pending is None:
            return
        if pending.kind is Kind.SLEEP:
            self._answered(process, pending, NOTHING, "")
        elif pending.kind is Kind.EVIDENCE:
            came = self._arrived(process, pending)
            self._answered(process, pending, _raw(came), "", trigger=Trigger.EXPIRE)
        else:
            self._answered(process, pending, NOTHING, EXPIRED, trigger=Trigger.EXPIRE)

    # --- slots ---

    def _settle(self) -> None:
        """Give the slots to whom the policy picks, until nobody needs to move; then let the holders' steps run."""
        self._ask_the_reasoner()
        if self._wait_for_tick():
            return
        while True:
            running = [each for each in self.processes.active if not self.processes[each].held]
            pick = self._policy.pick(running, self._slots, self._host.now_ns)
            for each in pick.abandon:
                self._move(self.processes[each], Trigger.ABANDON)
            if pick.abandon:
                continue
            newcomers = [each for each in pick.run if each not in self.processes.active]
            for each in list(self.processes.active):
                process = self.processes[each]
                if each not in pick.run and not process.stepping:
                    by = process.held_by or (f"P{newcomers[0]}" if newcomers else "policy")
                    self._move(process, Trigger.PREEMPT, by=by)
            free = self._slots - len(self.processes.active)
            if not newcomers or free <= 0:
                break
            self._dispatch(self.processes[newcomers[0]])
        if pick.again_ns is not None and pick.again_ns > self._host.now_ns:
            self._ask_again(pick.again_ns)
        self._ask_the_reasoner()
        for each in self.processes.active:
            self._begin_step(self.processes[each])

    def _begin_step(self, process: Process) -> None:
        if not process.stepping:
            process.stepping = True
            due_ns = process.active_since_ns + (process.ran + 1) * self._step_ns
            heapq.heappush(self._due, (due_ns, _STEP, process.id, 0))

    def _wait_for_tick(self) -> bool:
        """In slotted time nobody moves between two ticks; whether that is so now."""
        now_ns = self._host.now_ns
        if not self._host.settings.slotted or not self._step_ns or now_ns % self._step_ns == 0:
            return False
        self._ask_again(now_ns - now_ns % self._step_ns + self._step_ns)
        return True

    def _ask_again(self, at_ns: int) -> None:
        """Settle at that instant whatever else falls due, unless that is to be done sooner anyway."""
        if self._tick_ns is None or at_ns < self._tick_ns:
            self._tick_ns = at_ns
            heapq.heappush(self._due, (at_ns, _TICK, 0, 0))

    def _dispatch(self, process: Process) -> None:
        self._move(process, Trigger.DISPATCH)
        if process.coroutine is None:
            self._rebuild(process)
        elif isinstance(process.want, Want):
            answered = process.answers[process.asked[-1].seq]
            self._go_on(process, lambda: self._coroutines.answer(process, _want(process), answered))

    def _rebuild(self, process: Process) -> None:
        self._go_on(process, lambda: self._coroutines.rebuild(process, process.steps + process.ran))

    def _resume(self, process: Process) -> None:
        self._go_on(process, lambda: self._coroutines.send(process, None))

    def _go_on(self, process: Process, run: Callable[[], Step]) -> None:
        """Run the coroutine on until it works, waits or ends. ``run`` gives its next want."""
        step = self._attempt(process, run)
        while step is not None:
            excess = self._excess(process, step)
            if excess:
                self._fail(process, excess)
                return
            if isinstance(step, Work):
                process.want = step
                return
            if isinstance(step, Result):
                self._conclude(process, step)
                return
            step = self._ask(process, step)

    def _excess(self, process: Process, step: Step) -> str:
        """What is wrong with a want or a result, so that the attempt has failed; empty where nothing is."""
        own = self._host.settings
        if isinstance(step, Result):
            return objection(step)
        if isinstance(step, Work):
            spent = process.steps + process.ran - process.base_steps + step.left
            return f"it wanted {spent} steps of work in all; at most {own.max_steps} are given" if spent > own.max_steps else ""
        if step.within_s is not None and not step.within_s <= LONGEST_S:
            return f"it wanted to wait {step.within_s} s for {step.kind}; every wait needs a limit of at most {LONGEST_S:g} s"
        if process.pending is None and process.next_seq - process.base_seq > own.max_requests:
            return f"it made more than {own.max_requests} requests"
        if step.kind is Kind.TREAT and self._depth(process) >= own.max_depth:
            return f"its children were nested deeper than {own.max_depth}"
        return ""

    def _depth(self, process: Process) -> int:
        depth = 0
        above = self.processes.get(process.parent)
        while above is not None:
            depth += 1
            above = self.processes.get(above.parent)
        return depth

    def _attempt(self, process: Process, run: Callable[[], Step]) -> Step | None:
        try:
            return run()
        except Mismatch as mismatch:
            self._restart(process, mismatch)
        except Failure as failure:
            self._fail(process, str(failure))
        return None

    def _restart(self, process: Process, mismatch: Mismatch) -> None:
        """Begin again from the event: named, never stranded."""
        detail = f"{mismatch}; restarted from its event"
        self._host.note("code no longer matches its record", detail, process.id, process.event.id)
        self._move(process, Trigger.RESTART)

    def _fail(self, process: Process, why: str) -> None:
        """Continue in fallback mode; what fails there too is completed as unresolved, and is debt."""
        decision = process.decision
        if decision is not None and decision.mode != "fallback":
            self._host.note("treatment failed", f"{decision.treatment}: {why}", process.id, process.event.id)
            self._move(process, Trigger.RESTART)
            self._host.write(Decided(process=process.id, event=process.event.id, decision=provisional(decision, why)))
            return
        self._host.note("treatment failed in fallback mode", why, process.id, process.event.id)
        unresolved = Unresolved(says=f"No treatment could be completed: {why}", confidence=0.0, failure=why)
        self._conclude(process, unresolved, Trigger.FAIL)

    # --- asking and answering ---

    def _ask(self, process: Process, want: Want) -> Step | None:
        """Record the request; answer it at once where that can be done, else let the process wait."""
        pending = process.pending
        fresh = pending is None
        if pending is None:
            now_ns = self._host.now_ns
            pending = Asked(
                process=process.id,
                seq=process.next_seq,
                kind=want.kind,
                key=want.key,
                expires_ns=None if want.within_s is None else now_ns + to_ns(max(0.0, want.within_s)),
                safety=want.safety,
                args=want.digest(),
                count=want.count,
                detail=_raw(want.event) if want.event is not None and want.event != process.event else NOTHING,
            )
            self._host.write(pending)
        process.want = want
        if want.kind is Kind.RECALL and want.query is not None:
            return self._answer_at_once(process, want, pending, _raw(self._host.recall(want.query)))
        if want.kind is Kind.EVIDENCE:
            came = self._arrived(process, pending)
            if len(came) >= pending.count:
                return self._answer_at_once(process, want, pending, _raw(came[-pending.count :]))
        if fresh:
            self._move(process, Trigger.ASK)
            self._limit(process, pending)
            self._go_outside(process, want, pending)
        return None

    def _answer_at_once(self, process: Process, want: Want, pending: Asked, value: Raw) -> Step | None:
        answered = Answered(process=process.id, seq=pending.seq, kind=pending.kind, key=pending.key, value=value)
        self._host.write(answered)
        return self._attempt(process, lambda: self._coroutines.answer(process, want, answered))

    def _limit(self, process: Process, pending: Asked) -> None:
        if pending.expires_ns is not None:
            heapq.heappush(self._due, (pending.expires_ns, _LIMIT, process.id, pending.seq))

    def _go_outside(self, process: Process, want: Want, pending: Asked) -> None:
        if want.kind is Kind.TREAT:
            decision = process.decision
            event = want.event or process.event
            if decision is not None:
                child = msgspec.structs.replace(decision, treatment=want.key, reasons=(f"asked for by P{process.id}",))
                self.create(event, child, deadline_ns=process.deadline_ns, parent=process.id)
        elif want.kind in _OUTSIDE and want.kind is not Kind.DELIBERATE:
            self._call(process, want, pending, process.asked_ns)

    def _ask_the_reasoner(self) -> None:
        """Have the calls made whose turn has come; the others queue in the process set. After a recovery: all under way."""
        for each, since_ns in self.processes.reasoner_calls.take():
            process = self.processes[each]
            pending = process.pending
            if pending is None or not isinstance(process.want, Want):
                continue
            if pending.expires_ns is None or pending.expires_ns > self._host.now_ns:  # else its limit passes at this instant
                self._call(process, process.want, pending, since_ns)

    def _call(self, process: Process, want: Want, pending: Asked, since_ns: int) -> None:
        self._host.call(
            Call(
                process=process.id,
                seq=pending.seq,
                asked_ns=since_ns,
                expires_ns=pending.expires_ns if pending.expires_ns is not None else since_ns,
                question=want.question,
                role=want.role,
                function=want.function,
                safety=want.safety,
                key=f"{process.event.id}/{process.id}/{pending.seq}",
            )
        )

    def answer(self, answer: Answer) -> None:
        """A call's answer. One that comes twice, or for a process that is gone, is passed over."""
        process = self.processes.get(answer.process)
        pending = process.pending if process is not None else None
        if process is None or pending is None or pending.seq != answer.seq or pending.kind not in _OUTSIDE:
            return
        self._answered(process, pending, answer.value, answer.error, answer.cost_usd, answer.calls)
        if pending.key == WHICH_TREATMENT and not answer.error and process.decision is not None:
            reply = msgspec.json.decode(answer.value, type=Reply)
            decision = revised(process.decision, reply, self._host.counselled(process.decision, reply))
            self._host.write(Decided(process=process.id, event=process.event.id, decision=decision))
        self._settle()

    def _answered(
        self,
        process: Process,
        pending: Asked,
        value: Raw,
        error: str,
        cost_usd: float = 0.0,
        calls: int = 0,
        trigger: Trigger = Trigger.WAKE,
    ) -> None:
        self._host.write(
            Answered(
                process=process.id,
                seq=pending.seq,
                kind=pending.kind,
                key=pending.key,
                value=value,
                error=error,
                cost_usd=cost_usd,
                calls=calls,
            )
        )
        self._move(process, trigger, by=pending.key.replace("\x1f", " "))

    # --- evidence and conditions ---

    def deliver(self, evidence: Evidence) -> None:
        """Keep the evidence, and wake whoever has now all that it asked for."""
        if not self.shelf.put(evidence):
            return
        topic_key = f"{evidence.topic}\x1f{evidence.key}"
        for process in self.processes.expecting(topic_key):
            pending = process.pending
            if pending is not None:
                came = self._arrived(process, pending)
                if len(came) >= pending.count:
                    self._answered(process, pending, _raw(came[-pending.count :]), "")
        self._settle()

    def _arrived(self, process: Process, pending: Asked) -> tuple[Evidence, ...]:
        taken = process.taken.get(pending.key, ())
        asked_ns = process.asked_ns
        return tuple(each for each in self.shelf.of(pending.key, asked_ns) if each.id not in taken)

    def moot(self, condition: str) -> None:
        """The condition cleared: what still waits about it has become moot. What is being worked on goes on."""
        for process in self.processes.lasting(condition):
            if process.state is State.WAITING:
                self._move(process, Trigger.MOOT, by="condition cleared")
        self._settle()

    # --- ends ---

    def _conclude(self, process: Process, result: Result, trigger: Trigger = Trigger.RESOLVE) -> None:
        decision = process.decision
        root = process.parent == 0
        forecast = result.forecast if root else None
        record = Concluded(
            process=process.id,
            event=process.event.id,
            treatment=decision.treatment if decision is not None else "",
            mode=decision.mode if decision is not None else "",
            result=_raw(result),
            forecast=forecast,
            closes_ns=self._host.closes_ns(process.arrived_ns) if forecast is not None else None,
        )
        self._host.write(record)
        self._move(process, trigger)
        if process.parent:
            self._tell_parent(process, record.result)
        self._host.concluded(record)

    def _tell_parent(self, process: Process, value: Raw, error: str = "") -> None:
        parent = self.processes.get(process.parent)
        pending = parent.pending if parent is not None else None
        treatment = process.decision.treatment if process.decision is not None else ""
        if parent is not None and pending is not None and pending.kind is Kind.TREAT and pending.key == treatment:
            self._answered(parent, pending, value, error)

    # --- operators ---

    def act(self, act: Act) -> None:
        """Take up an operator's act, and give the slots anew. One whose id was taken up before is passed over."""
        self.take(act)
        self._settle()

    def take(self, act: Act) -> None:
        """Record the act and what it does, and move nobody else: all that is done to a journal at rest.

        A hold and its release are flags. A cancel completes the process and its children; whoever waits for it hears so.
        """
        if act.id and self.processes.acted(act.id):
            return
        process = self.processes.get(act.process)
        refused = f"process {act.process} is not open" if process is None and act.act in ON_OPEN else ""
        self._host.write(Acted(who=act.who, act=act.act, process=act.process, why=act.why, id=act.id, refused=refused))
        if process is not None and act.act == "cancel":
            self._cancel(process, act.who)

    def _cancel(self, process: Process, who: str) -> None:
        self._move(process, Trigger.CANCEL, by=who)
        for child in self.processes.children(process.id):
            self._cancel(child, who)
        self._tell_parent(process, NOTHING, f"cancelled by {who}")

    def _move(self, process: Process, trigger: Trigger, by: str = "") -> None:
        steps = process.steps + (process.ran if process.state is State.ACTIVE else 0)
        self._host.write(
            Moved(
                process=process.id,
                before=process.state,
                trigger=trigger,
                after=after(process.state, trigger),
                steps=steps,
                by=by,
            )
        )

    # --- recovery ---

    def recover(self) -> None:
        """Go on from the recorded state: holders of slots where their steps stood, waiting calls made again."""
        now_ns = self._host.now_ns
        for process in list(self.processes):
            if process.state is State.ACTIVE:
                elapsed_ns = now_ns - process.active_since_ns
                process.ran = elapsed_ns // self._step_ns if self._step_ns else 0
                self.processes.stepped(process, now_ns)
                self._rebuild(process)
                if process.state is State.ACTIVE:
                    self._begin_step(process)  # it was within that step: nobody takes its slot before the step's end
            elif process.state is State.WAITING:
                self._wait_again(process)
        self._settle()

    def _wait_again(self, process: Process) -> None:
        pending = process.pending
        if pending is None:
            return
        self._limit(process, pending)
        if pending.kind not in _OUTSIDE:
            return
        if pending.safety == "effect":
            self._answered(process, pending, NOTHING, IN_DOUBT)
            return
        try:
            want = self._coroutines.rebuild(process, process.steps)
        except Mismatch as mismatch:
            self._restart(process, mismatch)
            return
        except Failure as failure:
            self._host.note("treatment failed", str(failure), process.id, process.event.id)
            self._move(process, Trigger.RESTART)
            return
        if isinstance(want, Want):
            process.want = want
            self._go_outside(process, want, pending)


def _raw(value: object) -> Raw:
    return msgspec.Raw(msgspec.json.encode(value))


def _want(process: Process) -> Want:
    if not isinstance(process.want, Want):
        raise Mismatch("the process was not asking for anything")
    return process.want
