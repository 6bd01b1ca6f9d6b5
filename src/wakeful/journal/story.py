"""The story of one event: everything that `why` tells, gathered from a journal."""

from __future__ import annotations

from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard
from wakeful.facts.lines import Judged, Line, Noted, Trusted
from wakeful.facts.results import Forecast
from wakeful.facts.values import NOTHING, Raw
from wakeful.journal.history import EventPast, History, ProcessPast
from wakeful.journal.readable import View


class NoSuchEvent(Exception):
    """No event has that id, or several do. ``close`` are the ids that were meant, perhaps."""

    def __init__(self, says: str, close: tuple[str, ...] = ()) -> None:
        super().__init__(says)
        self.close = close


class VerdictTold(View, frozen=True):
    """One verdict with the outcome that brought it, where one came."""

    at_ns: int
    judged: Judged
    outcome: Outcome | None = None


class ProcessStory(View, frozen=True):
    """One process about the event. ``role`` is root, child or reopening."""

    id: int
    role: str
    treatment: str
    state: str
    created_ns: int
    decisions: tuple[Decision, ...]
    trail: tuple[Line, ...]
    """Its transitions, requests and answers, in order."""
    steps: int = 0
    end: str = ""
    parent: int = 0
    reopens: int = 0
    because: str = ""
    held_by: str = ""
    deadline_ns: int | None = None
    result: Raw = NOTHING
    forecast: Forecast | None = None
    concluded_ns: int | None = None
    closes_ns: int | None = None
    verdicts: tuple[VerdictTold, ...] = ()
    notes: tuple[Noted, ...] = ()


class Remembered(View, frozen=True):
    """An experience that a decision rested on, with what its event was."""

    experience: Experience
    kind: str = ""
    entity: str = ""
    says: str = ""


class TrustTold(View, frozen=True):
    """A change of trust that this event's experience brought."""

    at_ns: int
    trusted: Trusted


class Story(View, frozen=True):
    """All that the journal knows of one event. Instants are kernel time; ``offset_ns`` takes them to source time."""

    event: Event
    position: int
    admitted_ns: int
    duplicates: int
    now_ns: int
    processes: tuple[ProcessStory, ...]
    rests_on: tuple[Remembered, ...]
    lineage: tuple[ModelCard, ...]
    trust: tuple[TrustTold, ...]
    experiences: tuple[Experience, ...]


def find_event(read: History, prefix: str) -> EventPast:
    """The event whose id begins with ``prefix``.

    Raises:
        NoSuchEvent: there is none, or more than one; ``close`` names up to five.
    """
    wanted = prefix.strip().lower()
    if wanted in read.events:
        return read.events[wanted]
    found = [identity for identity in read.events if wanted and identity.startswith(wanted)]
    if len(found) == 1:
        return read.events[found[0]]
    if found:
        raise NoSuchEvent(f"{len(found)} events begin with {prefix!r}", tuple(found[:5]))
    raise NoSuchEvent(f"no event {prefix!r}", _close(read, wanted))


def _close(read: History, wanted: str) -> tuple[str, ...]:
    """The ids that share the longest beginning with what was typed; the last admitted ones where none shares any."""

    def shared(identity: str) -> int:
        return next((index for index, (a, b) in enumerate(zip(identity, wanted, strict=False)) if a != b), len(wanted))

    ranked = sorted(read.events, key=lambda identity: -shared(identity))
    near = [identity for identity in ranked[:5] if shared(identity) >= 2]
    return tuple(near or list(read.events)[-3:])


def story(read: History, past: EventPast) -> Story:
    """Gather one event's story.

    Args:
        read: the journal's history.
        past: the event, as ``find_event`` gave it.
    """
    processes = [read.processes[process] for process in past.processes]
    mine = {process.id for process in processes}
    experiences = tuple(gained.experience for gained in read.gained.values() if gained.experience.process in mine)
    gained = {experience.id for experience in experiences}
    decisions = [decision for process in processes for decision in process.decisions]
    rests_on = dict.fromkeys(identity for decision in decisions for identity in decision.rests_on)
    return Story(
        event=past.event,
        position=past.position,
        admitted_ns=past.admitted_ns,
        duplicates=past.duplicates,
        now_ns=read.now_ns,
        processes=tuple(_process(read, process) for process in processes),
        rests_on=tuple(_remembered(read, identity) for identity in rests_on if identity in read.gained),
        lineage=lineage(read, max((decision.model for decision in decisions), default=0)),
        trust=tuple(TrustTold(at_ns=at_ns, trusted=trusted) for at_ns, trusted in read.trusted if trusted.experience in gained),
        experiences=experiences,
    )


def lineage(read: History, version: int) -> tuple[ModelCard, ...]:
    """A model version and what it came from, newest first."""
    cards = {published.card.version: published.card for _, published in read.published}
    line: list[ModelCard] = []
    while version in cards and cards[version] not in line:
        line.append(cards[version])
        version = cards[version].base
    return tuple(line)


def _remembered(read: History, identity: int) -> Remembered:
    experience = read.gained[identity].experience
    past = read.events.get(experience.event)
    if past is None:
        return Remembered(experience=experience)
    return Remembered(experience=experience, kind=past.event.kind, entity=past.event.entity, says=past.event.says)


def _process(read: History, process: ProcessPast) -> ProcessStory:
    reopened = read.reopened.get(process.id)
    concluded = process.concluded
    return ProcessStory(
        id=process.id,
        role="child" if process.parent else "reopening" if process.reopens else "root",
        treatment=process.treatment,
        state=process.state.value,
        created_ns=process.created_ns,
        decisions=tuple(process.decisions),
        trail=tuple(process.trail),
        steps=process.steps,
        end=process.end or "",
        parent=process.parent,
        reopens=process.reopens,
        because=reopened.because if reopened else "",
        held_by=process.held_by,
        deadline_ns=process.deadline_ns,
        result=concluded.result if concluded else NOTHING,
        forecast=concluded.forecast if concluded else None,
        concluded_ns=process.concluded_ns if concluded else None,
        closes_ns=concluded.closes_ns if concluded else None,
        verdicts=tuple(
            VerdictTold(at_ns=at_ns, judged=judged, outcome=read.outcomes.get(judged.outcome))
            for at_ns, judged in process.verdicts
        ),
        notes=tuple(process.notes),
    )
