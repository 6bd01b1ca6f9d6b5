"""The process set (Eq. 5): every open process, folded from the journal's records, and the policy kept informed."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import msgspec

from wakeful.contracts.policy import ConservingPolicy, LearningPolicy, ParkingPolicy, Policy
from wakeful.facts.asking import Kind
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.lines import Acted, Answered, AnyRecord, Asked, Compacted, Created, Decided, Moved, Noted
from wakeful.facts.packs import Covered, Inquired, Ran, Woken
from wakeful.facts.processes import State, Trigger, after
from wakeful.scheduling.backlog import Backlog
from wakeful.scheduling.crashes import Crashes
from wakeful.scheduling.expecting import Expecting
from wakeful.scheduling.parked import Parked
from wakeful.scheduling.process import Process, Recorded
from wakeful.scheduling.reasoner_calls import ReasonerCalls

_EVENT = msgspec.json.Decoder(Event)
_EVIDENCE = msgspec.json.Decoder(tuple[Evidence, ...])


class ProcessSet:
    """Open processes by id. Completed ones are forgotten; the journal remembers them.

    Args:
        policy: told of every change, in the order of the records, live and in recovery alike.
        event_of: finds the event of a root process; a child's event stands in its parent's request.
        reasoner_slots: how many calls of the reasoner may be under way at once; 0: no limit.
    """

    def __init__(self, policy: Policy, event_of: Callable[[str], Event], reasoner_slots: int = 0) -> None:
        self._policy = policy
        self._through = policy if isinstance(policy, ConservingPolicy) else None
        self._untold: Process | None = None
        self.reasoner_calls = ReasonerCalls(reasoner_slots)
        self.crashes = Crashes()
        self.not_begun = Backlog()
        self._parks = policy if isinstance(policy, ParkingPolicy) else None
        self._learns = policy if isinstance(policy, LearningPolicy) else None
        self._event_of = event_of
        self._open: dict[int, Process] = {}
        self._runnable: set[int] = set()
        self._held: set[int] = set()
        self._acts: set[str] = set()
        self._active: list[int] = []
        self._last = 0
        self._expecting = Expecting()
        self.parked = Parked()

    @property
    def policy(self) -> Policy:
        """The policy, told of everything: what may run on at once is told of only when somebody asks."""
        self._tell()
        return self._policy

    def _tell(self) -> None:
        untold = self._untold
        if untold is not None:
            self._untold = None
            self._policy.runnable(untold.view(), untold.arrived_ns)

    def unrivalled(self, process: Process) -> bool:
        """Whether a policy that leaves no slot empty can but let this ready process run on at once: nobody else is ready."""
        return self._through is not None and len(self._runnable) == 1 and not self._active and not process.held_by

    @property
    def next_id(self) -> int:
        """The id of the next process."""
        return self._last + 1

    @property
    def active(self) -> list[int]:
        """The processes that hold slots, in the order in which they took them."""
        return self._active

    @property
    def runnable(self) -> int:
        """How many processes could use a slot, or hold one; those that an operator holds can't."""
        return len(self._runnable) + len(self._active) - sum(1 for each in self._held if each in self._runnable)

    @property
    def backlog(self) -> int:
        """How many have not begun to be treated, or queue for the reasoner."""
        return len(self.not_begun) + self.reasoner_calls.queued

    def acted(self, identity: str) -> bool:
        """Whether an act of that id was taken up before."""
        return identity in self._acts

    def children(self, process: int) -> list[Process]:
        """The open children of a process, oldest first."""
        return [each for each in self._open.values() if each.parent == process]

    def __contains__(self, process: int) -> bool:
        return process in self._open

    def __iter__(self) -> Iterator[Process]:
        return iter(self._open.values())

    def __getitem__(self, process: int) -> Process:
        return self._open[process]

    def __len__(self) -> int:
        return len(self._open) + len(self.parked)

    @property
    def at_hand(self) -> int:
        """How many are in memory, not parked."""
        return len(self._open)

    def get(self, process: int) -> Process | None:
        """The open process of that id, if it is open."""
        return self._open.get(process)

    def lasting(self, condition: str) -> list[Process]:
        """The open processes about that condition, oldest first."""
        return [self._open[each] for each in self._expecting.about(condition)]

    def expecting(self, topic_key: str) -> list[Process]:
        """The open processes that wait for that evidence, oldest request first, then by id; parked ones have to be brought
        back before."""
        found = [self._open[each] for each in self._expecting.of(topic_key)]
        return found if len(found) < 2 else sorted(found, key=lambda each: (each.asked_ns, each.id))

    # --- parking: a long waiter is put out of memory, and brought back ---

    @property
    def parkable(self) -> int:
        """How many at hand nobody but their evidence, their limit or an operator will ask for."""
        return self._expecting.waiters

    def oldest(self, count: int) -> list[Process]:
        """The ``count`` of those that have waited longest."""
        return [self._open[each] for each in self._expecting.oldest(count)]

    def park(self, process: Process) -> tuple[int, ...]:
        """Take a parkable process out of memory; returns what the policy knows of it, to which it goes on waiting."""
        pending = process.pending
        if pending is None:
            raise ValueError(f"process {process.id} waits for nothing")
        del self._open[process.id]
        self._expecting.expects_no_more(process.id, pending.key)
        if process.coroutine is not None:
            process.coroutine.close()
            process.coroutine = process.mind = None
        self.parked.park(process.id, pending.key, pending.expires_ns)
        return self._parks.park(process.id) if self._parks is not None else ()

    def bring_back(self, recorded: Recorded, known: tuple[int, ...]) -> Process:
        """Have a parked process at hand again, as recovery would: its coroutine is rebuilt when it goes on."""
        self.parked.leave(recorded.id)
        process = Process(**msgspec.structs.asdict(recorded))
        self._open[process.id] = process
        if self._parks is not None:
            self._parks.bring_back(process.id, known)
        pending = process.pending
        if pending is not None:
            self._expecting.expects(process, pending.key)
        return process

    def stepped(self, process: Process, now_ns: int) -> None:
        """The holder of a slot has done steps since its dispatch: the policy sees how far it is."""
        if not process.held:
            self.policy.runnable(process.view(), now_ns)

    def apply(self, record: AnyRecord, now_ns: int) -> None:
        """Take up one record. The only way in which the set changes."""
        if isinstance(record, Moved):
            self._moved(record, now_ns)
        elif isinstance(record, Created):
            self._created(record, now_ns)
        elif isinstance(record, Compacted):
            self._last = max(self._last, record.process)
        elif isinstance(record, Decided):
            self._decided(self._open[record.process], record.decision, now_ns)
        elif isinstance(record, Asked):
            process = self._open[record.process]
            process.asked.append(record)
            process.asked_ns = now_ns
            if record.kind is Kind.EVIDENCE:
                self._expecting.expects(process, record.key)
            elif record.kind is Kind.DELIBERATE:
                view = process.view()
                key = (-view.criticality, -view.priority, view.arrived_ns)
                self.reasoner_calls.ask(process.id, key, now_ns, held=process.held)
        elif isinstance(record, Answered):
            self._answered(record, now_ns)
        elif isinstance(record, Acted):
            self._acted(record, now_ns)
        elif isinstance(record, Noted):
            self.crashes.apply(record)

    def _created(self, record: Created, now_ns: int) -> None:
        if record.parent:
            parent = self._open[record.parent]
            event = parent.event
            pending = parent.pending
            if pending is not None and bytes(pending.detail) != b"null":
                event = _EVENT.decode(pending.detail)
        else:
            event = self._event_of(record.event)
        if record.reopens:
            self.crashes.forget(record.event)
        process = Process(
            id=record.process,
            event=event,
            parent=record.parent,
            reopens=record.reopens,
            arrived_ns=now_ns,
            deadline_ns=record.deadline_ns,
            asked=[],
            answers={},
            answered_ns={},
            taken={},
        )
        self._open[process.id] = process
        self._last = process.id
        self.not_begun.came(process.id, event.source, now_ns)
        self._expecting.came(process)

    def _decided(self, process: Process, decision: Decision, now_ns: int) -> None:
        fresh = process.decided is None and process.choice is None
        if fresh or (process.base_seq == (process.asked[-1].seq if process.asked else 0) and process.steps == process.base_steps):
            process.first = decision
        process.decided = decision
        process.choice = None
        if process.mind is not None:
            process.mind.current = decision
        if fresh:
            self._runnable.add(process.id)
            self.policy.runnable(process.view(), now_ns)
        elif process.id in self._runnable and not process.held:
            self.policy.runnable(process.view(), now_ns)

    # --- packs: what their lines do, done at once ---

    def covered(self, burst: Covered, now_ns: int) -> Process:
        """An event has its process and its decision."""
        process = Process(
            id=burst.process, event=burst.event, arrived_ns=now_ns, deadline_ns=burst.deadline_ns, choice=burst.choice
        )
        self._open[process.id] = process
        self._last = process.id
        self._expecting.came(process)
        self._tell()  # of the one before
        self._untold = process
        self._runnable.add(process.id)
        return process

    def inquired(self, burst: Inquired, now_ns: int) -> None:
        """A process took a slot, worked and waits."""
        asked = burst.asked
        process = self._open[asked.process]
        self._runnable.discard(process.id)
        process.state = State.WAITING
        process.steps = burst.steps
        process.active_since_ns = process.asked_ns = now_ns
        process.ran = 0
        if process.started_ns is None:
            process.started_ns = now_ns
        process.asked.append(asked)
        if asked.kind is Kind.EVIDENCE:
            self._expecting.expects(process, asked.key)
        if process is self._untold:
            self._untold = None  # it has never stood among the ready ones
        self.policy.waiting(process.view(), now_ns)

    def woken(self, burst: Woken, now_ns: int) -> None:
        """What a process waited for came, or its limit passed."""
        process = self._open[burst.answered.process]
        self._answered(burst.answered, now_ns)
        process.state = State.SUSPENDED
        process.steps = burst.steps
        process.preempted_by = ""
        self._runnable.add(process.id)
        if not process.held:
            self.policy.runnable(process.view(), now_ns)

    def ran(self, burst: Ran, now_ns: int) -> Process:
        """A process took a slot, worked and concluded; returns it as it was."""
        process = self._open.pop(burst.process)
        self._runnable.discard(process.id)
        process.state = State.COMPLETED
        process.steps = burst.steps
        if process.started_ns is None:
            process.started_ns = now_ns
        self._expecting.gone(process)
        process.coroutine = process.mind = None
        if process is self._untold and self._through is not None:
            self._untold = None
            self._through.ran_through(burst.treatment, burst.mode, process.event.kind, burst.steps, now_ns)
            return process
        policy = self.policy
        if self._learns is not None:
            self._learns.completed(process.view(), now_ns)
        policy.gone(process.id, now_ns)
        return process

    def _answered(self, record: Answered, now_ns: int) -> None:
        process = self._open[record.process]
        if record.kind is Kind.DELIBERATE:
            self.reasoner_calls.leave(process.id, now_ns)
        process.answers[record.seq] = record
        process.answered_ns[record.seq] = now_ns
        if record.kind is Kind.EVIDENCE:
            self._expecting.expects_no_more(process.id, record.key)
            had = () if record.error else tuple(each.id for each in _EVIDENCE.decode(record.value))
            process.taken[record.key] = process.taken.get(record.key, ()) + had

    def _moved(self, record: Moved, now_ns: int) -> None:
        process = self._open[record.process]
        self._tell()
        before = process.state
        process.state = after(before, record.trigger)
        if before is State.CREATED:
            self.not_begun.left(process.id)
        process.steps = record.steps
        if before is State.ACTIVE:
            self._active.remove(process.id)
            process.stepping = False
            process.spent_ns += now_ns - process.active_since_ns
        self._runnable.discard(process.id)
        if record.trigger is Trigger.RESTART:
            self._restarted(process)
            self.reasoner_calls.leave(process.id, now_ns)
        if process.state is State.ACTIVE:
            self._active.append(process.id)
            process.active_since_ns = now_ns
            process.started_ns = now_ns if process.started_ns is None else process.started_ns
            process.ran = 0
        elif process.state is State.COMPLETED:
            if record.trigger is Trigger.RESOLVE and self._learns is not None:
                self._learns.completed(process.view(), now_ns)
            self._completed(process, now_ns)
        elif process.state is State.WAITING:
            if not process.held:
                self.policy.waiting(process.view(), now_ns)
        else:
            process.preempted_by = record.by if record.trigger is Trigger.PREEMPT else ""
            self._runnable.add(process.id)
            if not process.held:
                self.policy.runnable(process.view(), now_ns)

    def _restarted(self, process: Process) -> None:
        pending = process.pending
        if pending is not None and pending.kind is Kind.EVIDENCE:
            self._expecting.expects_no_more(process.id, pending.key)
        process.base_seq = process.asked[-1].seq if process.asked else 0
        process.base_steps = process.steps
        process.attempts += 1
        process.first = process.decision
        if process.coroutine is not None:
            process.coroutine.close()
        process.coroutine = process.mind = None
        process.want = None

    def _completed(self, process: Process, now_ns: int) -> None:
        del self._open[process.id]
        self._held.discard(process.id)
        self.reasoner_calls.leave(process.id, now_ns)
        pending = process.pending
        if pending is not None and pending.kind is Kind.EVIDENCE:
            self._expecting.expects_no_more(process.id, pending.key)
        self._expecting.gone(process)
        if process.coroutine is not None:
            process.coroutine.close()
            process.coroutine = process.mind = None
        self.policy.gone(process.id, now_ns)

    def _acted(self, record: Acted, now_ns: int) -> None:
        if record.id:
            self._acts.add(record.id)
        process = self._open.get(record.process)
        if process is None or record.refused:
            return
        if record.act == "hold":
            process.held_by = record.who or "an operator"
            self.not_begun.left(process.id)
            self._held.add(process.id)
            self._expecting.held(process.id)
            self.policy.gone(process.id, now_ns)
            self.reasoner_calls.hold(process.id)
        elif record.act == "release" and process.held:
            process.held_by = ""
            self._held.discard(process.id)
            if process.state is State.CREATED:
                self.not_begun.came(process.id, process.event.source, now_ns)
            self.reasoner_calls.let_go(process.id, now_ns)
            if process.state is State.WAITING:
                self._expecting.released(process)
                self.policy.waiting(process.view(), now_ns)
            else:
                self.policy.runnable(process.view(), now_ns)
