"""One event, one process as a row of a list: what the command line prints as a table and the page shows."""

from __future__ import annotations

from wakeful.facts.time import to_s
from wakeful.journal.history import EventPast, History, ProcessPast
from wakeful.journal.readable import View
from wakeful.journal.wording.waiting import stands


class EventRow(View, frozen=True):
    """One event with how it was treated and how that ended."""

    id: str
    at_ns: int
    kind: str
    entity: str
    criticality: int
    says: str
    treatment: str
    mode: str
    state: str
    verdict: str
    processes: tuple[int, ...]


class ProcessRow(View, frozen=True):
    """One process as it stands. Ages and deadlines are in seconds of kernel time."""

    id: int
    event: str
    treatment: str
    mode: str
    state: str
    criticality: int
    age_s: float
    in_state_s: float
    steps: int
    stands: str
    parent: int = 0
    reopens: int = 0
    deadline_s: float | None = None


def event_row(read: History, past: EventPast) -> EventRow:
    """One event with how its root process stands."""
    root = read.root(past.event.id)
    event = past.event
    return EventRow(
        id=event.id,
        at_ns=event.stamp.source_ns,
        kind=event.kind,
        entity=event.entity,
        criticality=event.criticality,
        says=event.says,
        treatment=root.treatment if root else "",
        mode=root.decision.mode if root and root.decision else "",
        state=(root.end or root.state) if root else "uncovered",
        verdict=root.judged.verdict if root and root.judged else "",
        processes=tuple(past.processes),
    )


def process_row(read: History, process: ProcessPast) -> ProcessRow:
    """One process as of the journal's last line."""
    until_ns = read.now_ns if process.open else process.since_ns
    return ProcessRow(
        id=process.id,
        event=process.event,
        treatment=process.treatment,
        mode=process.decision.mode if process.decision else "",
        state=process.end or process.state,
        criticality=process.criticality,
        age_s=to_s(until_ns - process.created_ns),
        in_state_s=to_s(read.now_ns - process.since_ns),
        steps=process.steps,
        stands=stands(read, process),
        parent=process.parent,
        reopens=process.reopens,
        deadline_s=None if process.deadline_ns is None else to_s(process.deadline_ns - read.now_ns),
    )
