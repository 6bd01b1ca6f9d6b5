"""What a journal says about its events and processes: the fold of its lines, for reading only."""

from __future__ import annotations

import msgspec

from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import (
    Acted,
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Compacted,
    Concluded,
    Created,
    Decided,
    Drifted,
    Duplicate,
    Finished,
    Gained,
    Imported,
    Judged,
    Line,
    Moved,
    Noted,
    Opened,
    Published,
    Refused,
    Reopened,
    Trusted,
    Witnessed,
)
from wakeful.facts.processes import COMPLETIONS, Completion, State, Trigger
from wakeful.journal.readable import Readable


class ProcessPast(msgspec.Struct):
    """One process as the journal tells it. Instants are kernel time."""

    id: int
    event: str
    treatment: str
    criticality: int
    created_ns: int
    parent: int = 0
    reopens: int = 0
    deadline_ns: int | None = None
    state: State = State.CREATED
    since_ns: int = 0
    by: str = ""
    """Who moved it last: the process that preempted, the evidence that woke, the operator."""
    steps: int = 0
    first_treated_ns: int | None = None
    decisions: list[Decision] = []
    asked: dict[int, Asked] = {}
    answered: dict[int, Answered] = {}
    trigger: Trigger | None = None
    """What moved it last."""
    trail: list[Line] = []
    """Its transitions, requests and answers, in order."""
    concluded: Concluded | None = None
    concluded_ns: int = 0
    verdicts: list[tuple[int, Judged]] = []
    end: Completion | None = None
    held_by: str = ""
    held_why: str = ""
    notes: list[Noted] = []

    @property
    def decision(self) -> Decision | None:
        """The decision in force: a later one supersedes."""
        return self.decisions[-1] if self.decisions else None

    @property
    def judged(self) -> Judged | None:
        """The verdict that holds: of several the last that is not undecided."""
        decided = [judged for _, judged in self.verdicts if judged.verdict is not Verdict.UNDECIDED]
        return decided[-1] if decided else (self.verdicts[-1][1] if self.verdicts else None)

    @property
    def open(self) -> bool:
        """Whether it still thinks, waits or is ready."""
        return self.state is not State.COMPLETED

    def unanswered(self) -> list[Asked]:
        """What it asked for and has not been answered."""
        return [asked for seq, asked in self.asked.items() if seq not in self.answered]


#: Under what the refusals are counted whose reason is older than what is kept.
OLDER = "older than what is kept"


class EventPast(msgspec.Struct):
    """One admitted event, with its processes: the root first, then children and reopenings."""

    event: Event
    position: int
    admitted_ns: int
    processes: list[int] = []
    duplicates: int = 0


class History(msgspec.Struct):
    """Everything that the read views need, in the order of the journal."""

    last: int = 0
    now_ns: int = 0
    events: dict[str, EventPast] = {}
    processes: dict[int, ProcessPast] = {}
    opened: list[Opened] = []
    finished: list[Finished] = []
    duplicates: int = 0
    refused: dict[str, int] = {}
    given_up: int = 0
    """Events that were older than what is kept: of them nothing is known here but their number."""
    outcomes: dict[str, Outcome] = {}
    """What the world showed, by id, in the order of arrival."""
    gained: dict[int, Gained] = {}
    imported: dict[int, Imported] = {}
    """Other robots' experiences, by their id in this journal."""
    reopened: dict[int, Reopened] = {}
    """By the new process's id."""
    published: list[tuple[int, Published]] = []
    trusted: list[tuple[int, Trusted]] = []
    drifted: list[tuple[int, Drifted]] = []
    acted: list[tuple[int, Acted]] = []
    noted: list[tuple[int, Noted]] = []
    expired_waits: int = 0
    reasoner_calls: int = 0
    cost_usd: float = 0.0

    def root(self, event: str) -> ProcessPast | None:
        """The event's root process: the first that is neither a child nor a reopening."""
        past = self.events.get(event)
        for process in past.processes if past else ():
            found = self.processes[process]
            if not found.parent and not found.reopens:
                return found
        return None

    def roots(self) -> list[tuple[EventPast, ProcessPast]]:
        """Each admitted event with its root process, in the order of admission."""
        pairs = ((past, self.root(identity)) for identity, past in self.events.items())
        return [(past, process) for past, process in pairs if process is not None]

    def take(self, line: Line) -> None:
        """Take up one line. Lines about things that were never created are passed over: the audit names them."""
        self.last = max(self.last, line.position)
        self.now_ns = max(self.now_ns, line.at_ns)
        self._intake(line, line.record)
        self._thinking(line, line.record)
        self._learning(line, line.record)

    def _intake(self, line: Line, record: AnyRecord) -> None:
        match record:
            case Opened():
                self.opened.append(record)
            case Finished():
                self.finished.append(record)
            case Admitted(event=event):
                self.events.setdefault(event.id, EventPast(event, line.position, line.at_ns))
            case Duplicate():
                self.duplicates += 1
                if record.event in self.events:
                    self.events[record.event].duplicates += 1
            case Refused():
                self.refused[record.reason] = self.refused.get(record.reason, 0) + 1
            case Compacted():
                self.given_up += record.admitted
                self.duplicates += record.duplicate
                if record.refused:
                    self.refused[OLDER] = self.refused.get(OLDER, 0) + record.refused
            case Witnessed():
                self.outcomes.setdefault(record.outcome.id, record.outcome)
            case Created():
                self._create(line.at_ns, record)
            case _:
                pass

    def _create(self, at_ns: int, record: Created) -> None:
        if record.process in self.processes:
            return
        self.processes[record.process] = ProcessPast(
            id=record.process,
            event=record.event,
            treatment=record.treatment,
            criticality=record.criticality,
            created_ns=at_ns,
            parent=record.parent,
            reopens=record.reopens,
            deadline_ns=record.deadline_ns,
            since_ns=at_ns,
        )
        if record.event in self.events:
            self.events[record.event].processes.append(record.process)

    def _thinking(self, line: Line, record: AnyRecord) -> None:
        if isinstance(record, Answered):
            self.cost_usd += record.cost_usd
            self.reasoner_calls += record.calls
        if isinstance(record, Moved) and record.trigger is Trigger.EXPIRE:
            self.expired_waits += 1
        if not isinstance(record, Decided | Moved | Asked | Answered | Concluded | Judged | Acted | Noted):
            return
        process = self.processes.get(record.process)
        if process is None:
            return
        if isinstance(record, Moved | Asked | Answered):
            process.trail.append(line)
        match record:
            case Decided():
                process.decisions.append(record.decision)
                process.treatment = record.decision.treatment
            case Moved():
                _move(process, line.at_ns, record)
            case Asked():
                process.asked[record.seq] = record
                process.answered.pop(record.seq, None)
            case Answered():
                process.answered[record.seq] = record
            case Concluded():
                process.concluded, process.concluded_ns = record, line.at_ns
            case Judged():
                process.verdicts.append((line.at_ns, record))
            case Acted() if not record.refused and record.act in ("hold", "release"):
                process.held_by = record.who if record.act == "hold" else ""
                process.held_why = record.why if record.act == "hold" else ""
            case Noted():
                process.notes.append(record)

    def _learning(self, line: Line, record: AnyRecord) -> None:
        match record:
            case Gained():
                self.gained[record.experience.id] = record
            case Imported():
                self.imported[record.experience.id] = record
            case Reopened():
                self.reopened[record.process] = record
            case Published():
                self.published.append((line.at_ns, record))
            case Trusted():
                self.trusted.append((line.at_ns, record))
            case Drifted():
                self.drifted.append((line.at_ns, record))
            case Acted():
                self.acted.append((line.at_ns, record))
            case Noted():
                self.noted.append((line.at_ns, record))
            case _:
                pass


def _move(process: ProcessPast, at_ns: int, record: Moved) -> None:
    process.state, process.since_ns, process.by, process.trigger = record.after, at_ns, record.by, record.trigger
    process.steps = max(process.steps, record.steps)
    if record.trigger is Trigger.DISPATCH and process.first_treated_ns is None:
        process.first_treated_ns = at_ns
    if record.after is State.COMPLETED:
        process.end = COMPLETIONS.get(record.trigger)


def history(journal: Readable) -> History:
    """Read a whole journal once.

    Returns:
        the events and processes as of its last line. O(lines); nothing is written.
    """
    read = History()
    for line in journal.lines():
        read.take(line)
    return read


def waits_for(process: ProcessPast) -> list[Asked]:
    """What a waiting process waits for; empty for any other."""
    return process.unanswered() if process.state is State.WAITING else []
