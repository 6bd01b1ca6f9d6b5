"""Debt: events that hold only a provisional treatment, or none that was finished, and are owed a better one."""

from __future__ import annotations

from wakeful.facts.crashes import QUARANTINED
from wakeful.facts.processes import Completion
from wakeful.facts.time import to_s
from wakeful.journal.history import EventPast, History, ProcessPast
from wakeful.journal.readable import View

#: Ends that leave an event without a treatment of its own.
UNFINISHED = (Completion.UNRESOLVED, Completion.CANCELLED, Completion.ABANDONED)


class DebtRow(View, frozen=True):
    """One event in debt. ``because`` is ``fallback``, ``quarantined``, or how its last process ended."""

    id: str
    kind: str
    entity: str
    criticality: int
    age_s: float
    because: str
    who: str
    process: int
    says: str


def owing(read: History, past: EventPast) -> ProcessPast | None:
    """The last of the event's own processes (its root, and reopenings) if none of them gave it more than a provisional
    treatment; None where the event is owed nothing."""
    own = [read.processes[each] for each in past.processes if not read.processes[each].parent]
    if not own or any(_treats(process) for process in own):
        return None
    return own[-1]


def in_debt(read: History, past: EventPast) -> bool:
    """Whether an event holds only a provisional treatment (fallback, unresolved, cancelled) and no better one since."""
    return owing(read, past) is not None


def debt(read: History) -> list[DebtRow]:
    """The events in debt, by risk: the most critical first, then the oldest."""
    rows = [_row(read, past, process) for past in read.events.values() if (process := owing(read, past)) is not None]
    return sorted(rows, key=lambda row: (-row.criticality, -row.age_s, row.id))


def _treats(process: ProcessPast) -> bool:
    return process.decision is not None and process.decision.mode != "fallback" and process.end not in UNFINISHED


def quarantined(process: ProcessPast) -> bool:
    """Whether its code is not run again because it ended the mind's process too often."""
    return any(note.what == QUARANTINED for note in process.notes)


def _because(process: ProcessPast) -> str:
    if quarantined(process):
        return QUARANTINED
    return str(process.end) if process.end in UNFINISHED else "fallback"


def _row(read: History, past: EventPast, process: ProcessPast) -> DebtRow:
    event = past.event
    cancelled = process.end is Completion.CANCELLED
    return DebtRow(
        id=event.id,
        kind=event.kind,
        entity=event.entity,
        criticality=event.criticality,
        age_s=to_s(read.now_ns - past.admitted_ns),
        because=_because(process),
        who=process.by if cancelled else "",
        process=process.id,
        says=event.says,
    )
