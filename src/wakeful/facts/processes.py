"""The process table: every state change of a process stands in TRANSITIONS and nowhere else."""

from __future__ import annotations

from enum import StrEnum

from wakeful.facts.decisions import Mode
from wakeful.facts.values import Fact


class State(StrEnum):
    """Where a process is. ``active`` holds a slot; ``suspended`` was preempted or woken and is ready to go on."""

    CREATED = "created"
    ACTIVE = "active"
    WAITING = "waiting"
    SUSPENDED = "suspended"
    COMPLETED = "completed"


class Trigger(StrEnum):
    """What moves a process from one state to another."""

    DISPATCH = "dispatch"
    PREEMPT = "preempt"
    ASK = "ask"
    WAKE = "wake"
    EXPIRE = "expire"
    RESTART = "restart"
    RESOLVE = "resolve"
    FAIL = "fail"
    MOOT = "moot"
    CANCEL = "cancel"
    ABANDON = "abandon"


class Completion(StrEnum):
    """How a process ended. ``abandoned`` only experiments may allow; audit reports it as uncovered."""

    RESOLVED = "resolved"
    UNRESOLVED = "unresolved"
    MOOT = "moot"
    CANCELLED = "cancelled"
    ABANDONED = "abandoned"


_OPEN = (State.CREATED, State.ACTIVE, State.WAITING, State.SUSPENDED)

#: (state, trigger) -> next state. A pair that is not here is illegal, and the audit says so.
TRANSITIONS: dict[tuple[State, Trigger], State] = {
    (State.CREATED, Trigger.DISPATCH): State.ACTIVE,
    (State.SUSPENDED, Trigger.DISPATCH): State.ACTIVE,
    (State.ACTIVE, Trigger.PREEMPT): State.SUSPENDED,
    (State.ACTIVE, Trigger.ASK): State.WAITING,
    (State.WAITING, Trigger.WAKE): State.SUSPENDED,
    (State.WAITING, Trigger.EXPIRE): State.SUSPENDED,
    (State.ACTIVE, Trigger.RESTART): State.SUSPENDED,
    (State.WAITING, Trigger.RESTART): State.SUSPENDED,
    (State.SUSPENDED, Trigger.RESTART): State.SUSPENDED,
    (State.ACTIVE, Trigger.RESOLVE): State.COMPLETED,
    (State.ACTIVE, Trigger.FAIL): State.COMPLETED,
    **{(state, Trigger.MOOT): State.COMPLETED for state in _OPEN},
    **{(state, Trigger.CANCEL): State.COMPLETED for state in _OPEN},
    **{(state, Trigger.ABANDON): State.COMPLETED for state in _OPEN},
}

#: The triggers that end a process, and how the end is called.
COMPLETIONS: dict[Trigger, Completion] = {
    Trigger.RESOLVE: Completion.RESOLVED,
    Trigger.FAIL: Completion.UNRESOLVED,
    Trigger.MOOT: Completion.MOOT,
    Trigger.CANCEL: Completion.CANCELLED,
    Trigger.ABANDON: Completion.ABANDONED,
}


class IllegalTransition(Exception):
    """A trigger that the process table does not allow in the process's state."""


def after(state: State, trigger: Trigger) -> State:
    """The state that ``trigger`` leads to from ``state``.

    Raises:
        IllegalTransition: the pair is not in TRANSITIONS; nothing has changed.

    >>> after(State.WAITING, Trigger.WAKE)
    <State.SUSPENDED: 'suspended'>
    """
    try:
        return TRANSITIONS[state, trigger]
    except KeyError:
        raise IllegalTransition(f"a {state} process cannot {trigger}; see wakeful.facts.processes.TRANSITIONS") from None


class ProcessView(Fact, frozen=True):
    """What a policy may know of a process: nothing of the future, nothing of the treatment's insides."""

    id: int
    event: str
    treatment: str
    mode: Mode
    criticality: int
    arrived_ns: int
    steps_done: int
    task_relevant: bool = True
    priority: int = 0
    deadline_ns: int | None = None
    steps_needed: int | None = None
    """Where the world declares it (experiments) or history estimates it; None where nobody knows."""
    kind: str = ""
    """The event's kind: with the treatment, what a policy may learn from how long such processes took."""
    started_ns: int | None = None
    """When its first step began; None before that."""
    spent_ns: int = 0
    """For how long it has held a slot, up to the last time that it gave it up."""
    needs_evidence: bool | None = None
    """Whether it will wait for evidence before its last step, where the event says so; None where nobody knows."""
    evidence_due_ns: int | None = None
