"""A small pure builder of legal line sequences, for what reads journals."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import blake2b

import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.facts.asking import Kind
from wakeful.facts.decisions import Candidate, Decision, Gate, Mode
from wakeful.facts.events import Criticality, Event, event_id
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.lines import (
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Concluded,
    Created,
    Decided,
    Duplicate,
    Finished,
    Gained,
    Judged,
    Line,
    Moved,
    Opened,
    Published,
    Refused,
    Reopened,
    TrainingAsked,
    Trusted,
    Witnessed,
)
from wakeful.facts.processes import State, Trigger, after
from wakeful.facts.results import Forecast
from wakeful.facts.time import NS_PER_S, Stamp
from wakeful.facts.values import Raw

WINDOW_S = 30


def raw(value: object) -> Raw:
    """JSON text of plain data."""
    return Raw(msgspec.json.encode(value))


class Book:
    """A journal being written in legal lines. Each method appends what the kernel would; ``now_s`` is kernel time."""

    def __init__(self, source: str = "arm.xlsx", domain: str = "arm", domain_version: int = 1) -> None:
        self.written: list[Line] = []
        self.blobs: dict[str, bytes] = {}
        self.now_s = 0.0
        self._states: dict[int, State] = {}
        self._events: dict[int, str] = {}
        self._seqs: dict[int, int] = {}
        self._experiences = 0
        self.write(Opened(source=source, digest="d1", domain=domain, domain_version=domain_version, offset_ns=0, seed=0))

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The Readable protocol."""
        return iter(self.written[after:])

    def blob(self, name: str) -> bytes:
        """The Journal protocol."""
        try:
            return self.blobs[name]
        except KeyError:
            raise JournalError(f"there is no blob {name}") from None

    def write(self, record: AnyRecord) -> AnyRecord:
        """Append any record at the present instant."""
        self.written.append(Line(len(self.written) + 1, round(self.now_s * NS_PER_S), record))
        return record

    def wait(self, seconds: float) -> None:
        """Let kernel time pass."""
        self.now_s += seconds

    def admit(
        self,
        kind: str = "joint_current",
        entity: str = "joint_3",
        treatment: str = "diagnosis",
        mode: Mode = "delib",
        truth: str | None = None,
        criticality: Criticality = 1,
        novelty: float = 0.2,
        model: int = 0,
        rests_on: tuple[int, ...] = (),
        observations: int = 1,
    ) -> int:
        """Admit an event and cover it: its root process is created and decided. Returns the process's id."""
        position = len(self.written)
        identity = event_id("", "d1", position, kind, 0)
        at_ns = round(self.now_s * NS_PER_S)
        event = Event(
            id=identity,
            kind=kind,
            entity=entity,
            source="arm.xlsx",
            position=position,
            stamp=Stamp(source_ns=at_ns, received_ns=at_ns + 5),
            criticality=criticality,
            fields={"current_a": 2.5},
            says=f"{entity}: current left its band",
            truth_treatment=truth,
            observations=observations,
        )
        self.write(Admitted(event=event))
        return self.process(identity, treatment, mode, novelty=novelty, model=model, rests_on=rests_on, criticality=criticality)

    def process(
        self,
        event: str,
        treatment: str,
        mode: Mode = "delib",
        *,
        parent: int = 0,
        reopens: int = 0,
        novelty: float = 0.2,
        model: int = 0,
        rests_on: tuple[int, ...] = (),
        criticality: Criticality = 1,
    ) -> int:
        """Create and decide a process."""
        process = len(self._states) + 1
        self._states[process], self._events[process] = State.CREATED, event
        self.write(
            Created(process=process, event=event, treatment=treatment, criticality=criticality, parent=parent, reopens=reopens)
        )
        self.write(Decided(process=process, event=event, decision=decision(treatment, mode, novelty, model, rests_on)))
        return process

    def move(self, process: int, trigger: Trigger, by: str = "", steps: int = 0) -> None:
        """One transition of the process table."""
        before = self._states[process]
        self._states[process] = after(before, trigger)
        self.write(Moved(process=process, before=before, trigger=trigger, after=self._states[process], steps=steps, by=by))

    def ask(self, process: int, kind: Kind = Kind.EVIDENCE, key: str = "camera|joint_3", within_s: float | None = 10.0) -> int:
        """An active process asks, and waits. Returns the request's number."""
        seq = self._seqs[process] = self._seqs.get(process, 0) + 1
        expires_ns = None if within_s is None else round((self.now_s + within_s) * NS_PER_S)
        self.write(Asked(process=process, seq=seq, kind=kind, key=key, expires_ns=expires_ns, args=f"a{key}"))
        self.move(process, Trigger.ASK)
        return seq

    def answer(
        self,
        process: int,
        seq: int,
        kind: Kind = Kind.EVIDENCE,
        key: str = "camera|joint_3",
        error: str = "",
        value: object = "seen",
    ) -> None:
        """The answer comes, and the process is ready again."""
        calls = 1 if kind is Kind.DELIBERATE else 0
        self.write(
            Answered(
                process=process, seq=seq, kind=kind, key=key, value=raw(value), error=error, calls=calls, cost_usd=0.01 * calls
            )
        )
        self.move(process, Trigger.EXPIRE if error == "expired" else Trigger.WAKE)

    def conclude(self, process: int, label: str = "none", probability: float = 0.8, says: str = "joint 3 runs warm") -> None:
        """An active process ends with a result and a forecast."""
        event = self._events[process]
        forecast = Forecast(label=label, probability=probability, probabilities={label: probability})
        created = next(
            line.record for line in self.written if isinstance(line.record, Decided) and line.record.process == process
        )
        self.write(
            Concluded(
                process=process,
                event=event,
                treatment=created.decision.treatment,
                mode=created.decision.mode,
                result=raw({"type": "diagnosis", "says": says, "confidence": 0.7, "causes": ["gripper wear"]}),
                forecast=forecast,
                closes_ns=round((self.now_s + WINDOW_S) * NS_PER_S),
            )
        )
        self.move(process, Trigger.RESOLVE, steps=3)

    def witness(self, label: str, entity: str = "*") -> str:
        """The world shows an outcome. Returns its id."""
        identity = f"o{len(self.written)}"
        self.write(
            Witnessed(
                outcome=Outcome(id=identity, topic="outcome", entity=entity, label=label, at_ns=round(self.now_s * NS_PER_S))
            )
        )
        return identity

    def judge(self, process: int, predicted: str, label: str, outcome: str = "", gain: bool = True) -> int:
        """The verdict on a result, and the experience of it. Returns the experience's id."""
        verdict = Verdict.SUPPORTED if predicted == label else Verdict.CONTRADICTED
        event = self._events[process]
        self.write(
            Judged(
                process=process,
                event=event,
                predicted=predicted,
                label=label,
                verdict=verdict,
                outcome=outcome,
                lead_ns=NS_PER_S if outcome else None,
            )
        )
        if not gain:
            return 0
        self._experiences += 1
        concluded = next(
            (line.record for line in self.written if isinstance(line.record, Concluded) and line.record.process == process), None
        )
        treatment = concluded.treatment if concluded else "diagnosis"
        self.write(
            Gained(
                experience=Experience(
                    id=self._experiences,
                    event=event,
                    process=process,
                    treatment=treatment,
                    treatment_label=treatment if verdict is Verdict.SUPPORTED else "",
                    predicted=predicted,
                    outcome=label,
                    verdict=verdict,
                    mode=concluded.mode if concluded else "delib",
                )
            )
        )
        return self._experiences

    def train(self, training: int, base: int, version: int, accepted: bool = True, weights: bytes = b"") -> None:
        """A training is asked for and, two seconds later, answered."""
        self.write(
            TrainingAsked(
                training=training,
                base=base,
                watermark=self._experiences,
                seed=training,
                epochs=5,
                publish_ns=round((self.now_s + 2) * NS_PER_S),
            )
        )
        self.wait(2)
        weights = weights or f"weights of version {version}".encode()
        name = blake2b(weights, digest_size=16).hexdigest()
        self.blobs[name] = weights
        card = ModelCard(
            version=version,
            base=base,
            watermark=self._experiences,
            seed=training,
            epochs=5,
            blob=name,
            accepted=accepted,
        )
        self.write(Published(training=training, card=card))

    def run_through(self, process: int, label: str = "none") -> None:
        """Dispatch a process and let it conclude at once."""
        self.move(process, Trigger.DISPATCH)
        self.conclude(process, label)

    def event_of(self, process: int) -> str:
        """The id of the process's event."""
        return self._events[process]


def decision(treatment: str, mode: Mode, novelty: float = 0.2, model: int = 0, rests_on: tuple[int, ...] = ()) -> Decision:
    """A decision with two candidates."""
    return Decision(
        treatment=treatment,
        mode=mode,
        confidence=0.8,
        candidates=(Candidate(treatment=treatment, probability=0.8), Candidate(treatment="planning", probability=0.2)),
        reasons=("confidence 0.80 reaches the threshold 0.70",),
        gate=Gate(confidence=0.8, threshold=0.7, novelty=novelty, novelty_limit=0.95, trust=0.9, trust_limit=0.5),
        model=model,
        watermark=0,
        rests_on=rests_on,
    )


def full_book() -> Book:
    """A journal with something of everything: waits, a preemption, a child, a contradiction, a reopening, two models."""
    book = Book()
    first = book.admit(truth="diagnosis", observations=12)
    book.move(first, Trigger.DISPATCH)
    seq = book.ask(first)
    book.wait(2)
    book.answer(first, seq)
    book.move(first, Trigger.DISPATCH)
    book.wait(1)
    urgent = book.admit("grip_lost", "gripper", "planning", "fallback", criticality=3, novelty=0.99, truth="risk_prediction")
    book.move(first, Trigger.PREEMPT, by=str(urgent))
    book.run_through(urgent, "none")
    book.move(first, Trigger.DISPATCH)
    seq = book.ask(first, Kind.DELIBERATE, "which cause", 20)
    book.wait(1)
    book.answer(first, seq, Kind.DELIBERATE, "which cause")
    book.move(first, Trigger.DISPATCH)
    book.ask(first, Kind.TREAT, "memory", None)
    child = book.process(book.event_of(first), "memory", parent=first)
    book.run_through(child)
    book.answer(first, 3, Kind.TREAT, "memory")
    book.move(first, Trigger.DISPATCH)
    book.conclude(first, "none", 0.95)
    book.wait(4)
    outcome = book.witness("protective_stop")
    experience = book.judge(first, "none", "protective_stop", outcome)
    book.write(Trusted(treatment="diagnosis", before=0.9, after=0.6, why="contradicted", experience=experience))
    again = len(book._states) + 1
    book.write(Reopened(process=again, reopens=first, event=book.event_of(first), because="the world contradicted it"))
    book.process(book.event_of(first), "causal_analysis", reopens=first)
    book.run_through(again)
    book.wait(30)
    book.judge(urgent, "none", "none")
    book.train(1, 0, 1)
    book.train(2, 1, 2, accepted=False)
    for _ in range(3):
        auto = book.admit(mode="auto", model=1, rests_on=(1,), truth="diagnosis")
        book.run_through(auto)
        book.wait(31)
        book.judge(auto, "none", "none")
    book.write(Duplicate(event=book.event_of(first), source="arm.xlsx", position=3))
    book.write(Refused(source="arm.xlsx", position=4, reason="field 'x' is nan"))
    waiting = book.admit("temperature", "joint_1", "risk_prediction")
    book.move(waiting, Trigger.DISPATCH)
    book.ask(waiting, within_s=60)
    book.admit("temperature", "joint_2", "comparison")
    book.write(Finished(source="arm.xlsx", observations=500))
    return book
