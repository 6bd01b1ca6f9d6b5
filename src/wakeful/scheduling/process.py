"""One process as the kernel holds it: what was recorded of it, and its coroutine while it is warm."""

from __future__ import annotations

from collections.abc import Coroutine

import msgspec

from wakeful.facts.choices import Choice
from wakeful.facts.decisions import Decision, Mode
from wakeful.facts.events import Event
from wakeful.facts.lines import Answered, Asked, Moved
from wakeful.facts.processes import ProcessView, State, Trigger, after
from wakeful.facts.results import Result
from wakeful.scheduling.mind import KernelMind
from wakeful.scheduling.wants import Want, Work


class Recorded(msgspec.Struct, kw_only=True, omit_defaults=True):
    """What the journal's records say of one process: their fold."""

    id: int
    event: Event
    parent: int = 0
    reopens: int = 0
    arrived_ns: int
    deadline_ns: int | None = None
    state: State = State.CREATED
    choice: Choice | None = None
    """The automatic decision with which it began, as its numbers, until another one is made; then ``decided`` is None."""
    decided: Decision | None = None
    first: Decision | None = None
    steps: int = 0
    """Completed steps, as of the last transition; the steps since a dispatch are added at the next one."""
    active_since_ns: int = 0
    started_ns: int | None = None
    spent_ns: int = 0
    """For how long it held a slot, up to the last time that it gave it up."""
    held_by: str = ""
    """The operator who holds it; empty: nobody."""
    preempted_by: str = ""
    asked: list[Asked] = []
    asked_ns: int = 0
    """When the last request was made."""
    answers: dict[int, Answered] = {}
    answered_ns: dict[int, int] = {}
    """When each answer was recorded."""
    taken: dict[str, tuple[str, ...]] = {}
    """Ids of the evidence that it has had, by topic and key: none is delivered to it twice."""
    base_seq: int = 0
    """Requests up to this one belong to an earlier attempt (before a restart or a fallback)."""
    base_steps: int = 0
    attempts: int = 1


class Process(Recorded, kw_only=True):
    """A process at hand: what was recorded of it, and what is only in memory."""

    coroutine: Coroutine[object, object, Result] | None = None
    mind: KernelMind | None = None
    want: Work | Want | None = None
    stepping: bool = False
    """Within a step: it gives up its slot at the step's end at the earliest."""
    ran: int = 0
    """Steps since the dispatch."""

    def recorded(self) -> Recorded:
        """What was recorded of it, by itself."""
        return Recorded(**{name: getattr(self, name) for name in Recorded.__struct_fields__})

    @property
    def decision(self) -> Decision | None:
        """The decision in force."""
        if self.decided is None and self.choice is not None:
            self.decided = self.choice.decision()
        return self.decided

    @property
    def first_of_attempt(self) -> Decision | None:
        """The decision with which this attempt began."""
        return self.first if self.first is not None else self.decision

    @property
    def treatment(self) -> str:
        """The treatment in force; empty before there is a decision."""
        if self.choice is not None:
            return self.choice.basis.treatment
        return self.decided.treatment if self.decided is not None else ""

    @property
    def mode(self) -> Mode:
        """How it is executed."""
        if self.choice is not None:
            return "auto"
        return self.decided.mode if self.decided is not None else "fallback"

    @property
    def held(self) -> bool:
        """Whether an operator holds it: it keeps its state, and is not eligible."""
        return bool(self.held_by)

    @property
    def pending(self) -> Asked | None:
        """The request that waits for its answer, if any."""
        last = self.asked[-1] if self.asked else None
        return last if last is not None and last.seq > self.base_seq and last.seq not in self.answers else None

    def awaits(self, seq: int) -> bool:
        """Whether the request of that number is the one that waits for its answer."""
        return self.asked[-1].seq == seq and seq > self.base_seq and seq not in self.answers

    @property
    def next_seq(self) -> int:
        """The number of the next request."""
        return self.asked[-1].seq + 1 if self.asked else 1

    def moved(self, trigger: Trigger, by: str = "") -> Moved:
        """The record of its next transition; raises where the transition table has none."""
        return Moved(
            process=self.id,
            before=self.state,
            trigger=trigger,
            after=after(self.state, trigger),
            steps=self.steps + (self.ran if self.state is State.ACTIVE else 0),
            by=by,
        )

    def view(self) -> ProcessView:
        """What a policy may know of it."""
        pending = self.pending
        fields = self.event.context.fields
        priority = fields.get("priority", self.event.criticality)
        needed = fields.get("steps_needed")
        evidence = fields.get("needs_evidence")
        return ProcessView(
            id=self.id,
            event=self.event.id,
            treatment=self.treatment,
            mode=self.mode,
            criticality=self.event.criticality,
            arrived_ns=self.arrived_ns,
            steps_done=self.steps + (self.ran if self.state is State.ACTIVE else 0),
            task_relevant=bool(self.event.context.task),
            priority=priority if isinstance(priority, int) else int(self.event.criticality),
            deadline_ns=self.deadline_ns,
            steps_needed=needed if isinstance(needed, int) else None,
            kind=self.event.kind,
            started_ns=self.started_ns,
            spent_ns=self.spent_ns,
            needs_evidence=evidence if isinstance(evidence, bool) else None,
            evidence_due_ns=pending.expires_ns if pending else None,
        )
