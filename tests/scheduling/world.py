"""A host for the scheduler without the other rooms: records, applies, and can be killed and recovered at any instant."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

import msgspec

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode, Query, Reply
from wakeful.facts.decisions import Candidate, Decision, Gate, Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Condition, Event, Phase
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Answer, Call
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Line, Noted
from wakeful.facts.packs import AnyBurst, Ran
from wakeful.facts.results import Forecast, Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S, Stamp, to_ns
from wakeful.scheduling import Scheduler, SuspendResume
from wakeful.scheduling.evidence import EvidenceShelf

SPEC = DomainSpec(name="test", version=1, says="a test")
STEP_NS = NS_PER_S


class Said(Result, frozen=True, kw_only=True, tag="said"):
    """A result with nothing but its sentence."""


def say(text: str) -> Said:
    return Said(says=text, confidence=1.0)


class OneTreatment:
    """A treatment made of a function, without the treatments room."""

    version = 1
    says = "for a test"
    result = Said

    def __init__(self, name: str, think: Callable[[Event, Mind], Awaitable[Result]]) -> None:
        self.name = name
        self._think = think

    async def treat(self, event: Event, mind: Mind) -> Result:
        return await self._think(event, mind)


class Repertoire:
    """Treatments by name."""

    def __init__(self, **treatments: Callable[[Event, Mind], Awaitable[Result]]) -> None:
        self.of = {name: OneTreatment(name, think) for name, think in treatments.items()}

    def get(self, name: str) -> OneTreatment:
        return self.of[name]


class World:
    """The host. ``lines`` is its journal; ``crash`` forgets everything else."""

    def __init__(self, repertoire: Repertoire, slots: int = 1, reasoner_slots: int = 0) -> None:
        self.settings = MindSettings(step_s=1.0, slots=slots, reasoner_slots=reasoner_slots)
        self.repertoire = repertoire
        self.lines: list[Line] = []
        self.calls: list[Call] = []
        self.state: dict[str, bytes] = {}
        self.now_ns = 0
        self._begin()

    def _begin(self) -> None:
        self.events: dict[str, Event] = {}
        self.shelf = EvidenceShelf({}, to_ns(30.0))
        self.scheduler = Scheduler(self, SuspendResume(), self.repertoire, SPEC, tuple(self.repertoire.of), self.shelf)

    # --- Host ---

    def write(self, record: AnyRecord) -> None:
        self.lines.append(Line(len(self.lines) + 1, self.now_ns, record))
        self._apply(record)

    def _apply(self, record: AnyRecord) -> None:
        if isinstance(record, Admitted):
            self.events[record.event.id] = record.event
        self.scheduler.processes.apply(record, self.now_ns)

    def event(self, identity: str) -> Event:
        return self.events[identity]

    def call(self, call: Call) -> None:
        self.calls.append(call)

    def recall(self, query: Query) -> tuple[Episode, ...]:
        # What memory holds changes with every line: an answer that were asked for again would differ.
        return (Episode(event=query.event, kind="k", entity="e", at_ns=len(self.lines), likeness=1.0, treatment="t"),)

    def closes_ns(self, arrived_ns: int) -> int:
        return arrived_ns + to_ns(60.0)

    def counselled(self, decision: Decision, reply: Reply) -> dict[str, float]:
        return decision.prior

    def concluded(self, process: int) -> None:
        pass

    @property
    def steps_left(self) -> int | None:
        return None

    def spent(self, steps: int) -> None:
        pass

    def stir(self, at_ns: int) -> None:
        pass

    def resolved(self, burst: Ran, forecast: Forecast | None) -> None:
        self.pack(burst)

    def pack(self, burst: AnyBurst) -> None:
        for record in burst.records():
            self.write(record)

    def note(self, what: str, detail: str, process: int = 0, event: str = "") -> None:
        self.write(Noted(what=what, detail=detail, process=process, event=event))

    # --- what a test does ---

    def meet(self, name: str, treatment: str, criticality: int = 0, mode: Mode = "auto", condition: str = "") -> int:
        """Admit an event now, with that treatment; returns its process."""
        event = Event(
            id=name,
            kind="test",
            entity=name,
            source="test",
            position=len(self.lines),
            stamp=Stamp(source_ns=self.now_ns),
            criticality=criticality,  # type: ignore[arg-type]
            condition=Condition(key=condition, phase=Phase.RAISED) if condition else None,
        )
        self.write(Admitted(event=event))
        decision = Decision(
            treatment=treatment,
            mode=mode,
            confidence=1.0,
            candidates=(Candidate(treatment=treatment, probability=1.0),),
            reasons=("a test",),
            gate=Gate(confidence=1, threshold=0, novelty=0, novelty_limit=1, trust=1, trust_limit=0),
        )
        return self.scheduler.create(event, decision, deadline_ns=None)

    def tell(self, topic: str, key: str, value: object = None, identity: str = "") -> None:
        self.scheduler.deliver(
            Evidence(
                id=identity or f"{topic}/{key}/{self.now_ns}",
                topic=topic,
                key=key,
                at_ns=self.now_ns,
                value=msgspec.Raw(msgspec.json.encode(value)),
            )
        )

    def answer(self, value: object = None, error: str = "") -> None:
        """Answer the oldest call that is under way."""
        call = self.calls.pop(0)
        self.scheduler.answer(
            Answer(process=call.process, seq=call.seq, value=msgspec.Raw(msgspec.json.encode(value)), error=error)
        )

    def until(self, seconds: float) -> None:
        """Let kernel time pass up to that second."""
        until_ns = to_ns(seconds)
        while (due_ns := self.scheduler.next_due_ns()) is not None and due_ns <= until_ns:
            self.now_ns = max(self.now_ns, due_ns)
            self.scheduler.run_due()
        self.now_ns = max(self.now_ns, until_ns)

    def crash(self) -> None:
        """Forget everything but the journal, the committed state and the time, and recover."""
        for key, value in self.shelf.changed().items():
            if value is None:
                self.state.pop(key, None)
            else:
                self.state[key] = value
        now_ns, lines = self.now_ns, self.lines
        self.calls = []
        self._begin()
        for line in lines:
            self.now_ns = line.at_ns
            self._apply(line.record)
        self.now_ns = now_ns
        self.shelf.restore(self.state)
        self.scheduler.recover()

    def ends(self) -> list[tuple[str, str]]:
        """(event, sentence) of every conclusion so far, in order."""
        found = []
        for line in self.lines:
            if isinstance(line.record, Concluded):
                found.append((line.record.event, msgspec.json.decode(line.record.result)["says"]))
        return found
