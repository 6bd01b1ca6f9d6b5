"""The scheduler: gives slots to processes step by step, as the policy picks, and never loses one (Sec. III-B)."""

from __future__ import annotations

import msgspec

from wakeful.contracts.policy import Policy
from wakeful.facts.choices import Choice
from wakeful.facts.crashes import Page
from wakeful.facts.decisions import Decision
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Act, Answer
from wakeful.facts.lines import Acted, Concluded, Created, Decided
from wakeful.facts.overload import Load
from wakeful.facts.packs import Covered
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Result
from wakeful.facts.time import LARGEST_NS, to_ns, to_s
from wakeful.facts.values import NOTHING
from wakeful.scheduling.agenda import Agenda, Rank
from wakeful.scheduling.asking import Asking
from wakeful.scheduling.driving import Coroutines
from wakeful.scheduling.evidence import EvidenceShelf
from wakeful.scheduling.host import Host, Treatments
from wakeful.scheduling.process import Process, Recorded
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.running import Running
from wakeful.scheduling.straight import Straight
from wakeful.scheduling.wants import Want

#: The acts that need an open process.
ON_OPEN = ("hold", "release", "cancel")


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
        self._slots = host.settings.slots
        self._step_ns = to_ns(host.settings.step_s)
        self.shelf = shelf
        self.held_back = False
        self.processes = ProcessSet(policy, host.event, host.settings.reasoner_slots)
        self._coroutines = Coroutines(treatments.get, spec, options, host.settings.consult)
        self._agenda = Agenda(self.processes, self._step_ns, host.stir)
        self._asking = Asking(host, self.processes, self._agenda, shelf)
        self._running = Running(host, self.processes, self._coroutines, self._asking, self._begin_child)
        self._straight = Straight(host, self.processes, self._coroutines, self._asking, self._running, self._agenda)

    def load(self, source: str) -> Load:
        """How much is to be thought about now, and how much of it is of that source."""
        not_begun = self.processes.not_begun
        oldest_ns = not_begun.oldest_ns
        oldest_s = 0.0 if oldest_ns is None else to_s(self._host.now_ns - oldest_ns)
        return Load(self.processes.backlog, not_begun.of(source), oldest_s, len(self.processes))

    def mark_on(self, page: Page) -> None:
        """Say on that page, from now on, whose treatment's code is running."""
        self._coroutines.page = page

    def hold_back(self, hold: bool) -> None:
        """Give nobody a slot while it holds; letting go gives them."""
        let_go = self.held_back and not hold
        self.held_back = hold
        if let_go:
            self._settle()

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

    def cover(self, event: Event, choice: Choice, *, deadline_ns: int | None) -> None:
        """Give an event that was admitted just now a process with an automatic decision; where nobody else is ready, run it.

        Does what ``Admitted``, ``Created`` and ``Decided`` in turn would, as one entry of the journal.
        """
        number = self.processes.next_id
        self._host.pack(Covered(event=event, process=number, choice=choice, deadline_ns=deadline_ns))
        self._run_on(self.processes[number])

    def _run_on(self, process: Process) -> None:
        """Let a process that has just become ready run at once if it has no rival; else settle who runs."""
        if self.held_back or not self._straight.run(process):
            self._settle()

    def _begin_child(self, process: Process, want: Want) -> None:
        if process.decision is not None:
            reasons = (f"asked for by P{process.id}",)
            decision = msgspec.structs.replace(process.decision, treatment=want.key, reasons=reasons)
            self.create(want.event or process.event, decision, deadline_ns=process.deadline_ns, parent=process.id)

    def result(self, concluded: Concluded) -> Result:
        """A recorded result in its treatment's own type."""
        return self._coroutines.result(concluded.treatment, concluded.result)

    # --- time ---

    def next_due_ns(self) -> int | None:
        """When the next step ends or the next limit passes."""
        if self.held_back and self.processes.runnable:
            return self._host.now_ns
        return self._or_parked(self._agenda.next_ns())

    def passes_ns(self) -> int | None:
        """When the next limit passes: that it does when it is due, however many steps are put off, and while nobody may run."""
        return self._or_parked(self._agenda.passes_ns())

    def _or_parked(self, due_ns: int | None) -> int | None:
        soonest_ns = self.processes.parked.soonest_ns
        return soonest_ns if soonest_ns < (LARGEST_NS if due_ns is None else due_ns) else due_ns

    @property
    def step_next(self) -> bool:
        """Whether what falls due next is a step, and no limit."""
        return self._agenda.step_next and (self._agenda.next_ns() or 0) <= self.processes.parked.soonest_ns

    def run_due(self, passing: bool = False) -> None:
        """Do the first thing that is due: end one step, or let one limit pass; ``passing``: no step, whatever is due before."""
        for parked in self.processes.parked.until(self._host.now_ns):
            self._host.bring_back(parked)
        due = self._agenda.take(passing)
        if due is None:
            return
        if due.rank is Rank.STEP:
            self._running.step_ended(self.processes[due.process])
        elif due.rank is Rank.LIMIT:
            process = self.processes[due.process]
            if self._asking.limit_passed(process):
                self._run_on(process)
                return
        self._settle()

    # --- slots ---

    def _settle(self) -> None:
        """Give the slots to whom the policy picks, until nobody needs to move; then let the holders' steps run."""
        self._asking.ask_the_reasoner()
        if self.held_back or self._wait_for_tick():
            return
        while True:
            running = [each for each in self.processes.active if not self.processes[each].held]
            pick = self.processes.policy.pick(running, self._slots, self._host.now_ns)
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
            newcomer = self.processes[newcomers[0]]
            self._move(newcomer, Trigger.DISPATCH)
            self._running.dispatched(newcomer)
        if pick.again_ns is not None and pick.again_ns > self._host.now_ns:
            self._agenda.settle_at(pick.again_ns)
        self._asking.ask_the_reasoner()
        for each in self.processes.active:
            self._agenda.begin_step(self.processes[each])

    def _wait_for_tick(self) -> bool:
        """In slotted time nobody moves between two ticks; whether that is so now."""
        now_ns = self._host.now_ns
        if not self._host.settings.slotted or not self._step_ns or now_ns % self._step_ns == 0:
            return False
        self._agenda.settle_at(now_ns - now_ns % self._step_ns + self._step_ns)
        return True

    def _move(self, process: Process, trigger: Trigger, by: str = "") -> None:
        self._host.write(process.moved(trigger, by))

    # --- parking ---

    def bring_back(self, recorded: Recorded, known: tuple[int, ...]) -> None:
        """Have a parked process at hand again, with what the policy knows of it, its limit, and its coroutine."""
        process = self.processes.bring_back(recorded, known)
        if process.pending is not None:
            self._agenda.limit(process.pending)
        if not self.processes.crashes.of(process.event.id):
            self._running.warm(process)

    # --- what comes from outside ---

    def answer(self, answer: Answer) -> None:
        """A call's answer. One that comes twice, or for a process that is gone, is passed over."""
        if self._asking.take(answer):
            self._settle()

    def deliver(self, evidence: Evidence) -> None:
        """Keep the evidence, and wake whoever has now all that it asked for."""
        for parked in self.processes.parked.waiting_for(f"{evidence.topic}\x1f{evidence.key}"):
            self._host.bring_back(parked)
        woken = self._asking.deliver(evidence)
        if len(woken) == 1:
            self._run_on(woken[0])
        elif woken:
            self._settle()

    def moot(self, condition: str) -> None:
        """The condition cleared: what still waits about it has become moot. What is being worked on goes on."""
        for process in self.processes.lasting(condition):
            if process.state is State.WAITING:
                self._move(process, Trigger.MOOT, by="condition cleared")
        self._settle()

    # --- operators ---

    def act(self, act: Act) -> None:
        """Take up an operator's act, and give the slots anew. One whose id was taken up before is passed over."""
        self.take(act)
        self._settle()

    def take(self, act: Act) -> None:
        """Record the act and what it does, and move nobody else: all that is done to a journal at rest.

        A hold and its release are flags. A cancel completes the process and its children; whoever waits for it hears so. A
        completed process is reopened in a new one, linked to it.
        """
        if act.id and self.processes.acted(act.id):
            return
        if act.process in self.processes.parked:
            self._host.bring_back(act.process)
        process = self.processes.get(act.process)
        refused = f"process {act.process} is not open" if process is None and act.act in ON_OPEN else ""
        if act.act == "reopen":
            refused = f"process {act.process} is still open" if process is not None else self._host.closed_to(act)
        self._host.write(
            Acted(who=act.who, act=act.act, process=act.process, why=act.why, id=act.id, refused=refused, version=act.version)
        )
        if process is not None and act.act == "cancel":
            self._cancel(process, act.who)
        elif act.act == "reopen" and not refused:
            self._host.reopen(act)

    def _cancel(self, process: Process, who: str) -> None:
        self._move(process, Trigger.CANCEL, by=who)
        for child in self.processes.children(process.id):
            self._cancel(child, who)
        self._asking.tell_parent(process, NOTHING, f"cancelled by {who}")

    # --- recovery ---

    def recover(self) -> None:
        """Go on from the recorded state: holders of slots where their steps stood, waiting calls made again."""
        now_ns = self._host.now_ns
        for process in list(self.processes):
            if self._running.removed(process):
                continue
            if process.state is State.ACTIVE:
                elapsed_ns = now_ns - process.active_since_ns
                process.ran = elapsed_ns // self._step_ns if self._step_ns else 0
                self.processes.stepped(process, now_ns)
                self._running.rebuild(process)
                if process.state is State.ACTIVE:
                    self._agenda.begin_step(process)  # it was within that step: nobody takes its slot before the step's end
            elif process.state is State.WAITING and process.pending is not None:
                self._agenda.limit(process.pending)
                self._running.wait_again(process, process.pending)
        self._settle()
