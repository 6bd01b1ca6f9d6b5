"""A mind's validation alone: records are made and applied as the kernel would."""

from __future__ import annotations

from wakeful.facts.domain import DomainSpec, OutcomeSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Created, Finished, Gained, Judged, Moved, Witnessed
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Forecast
from wakeful.facts.time import NS_PER_S, Stamp
from wakeful.facts.values import NOTHING
from wakeful.validation import Validation

LABELS = ("none", "intervention", "failure")
WITHIN_S = 60.0
OFFSET_NS = 1_000 * NS_PER_S


def spec(scope: str = "entity") -> DomainSpec:
    return DomainSpec(
        name="bench", version=1, says="for tests", outcome=OutcomeSpec(labels=LABELS, within_s=WITHIN_S, scope=scope)
    )


class Bench:
    """Instants are seconds of source time; kernel time runs ``OFFSET_NS`` ahead of it."""

    def __init__(self, scope: str = "entity", **kept: int) -> None:
        self.validation = Validation(spec(scope), **kept)
        self.records: list[tuple[AnyRecord, int]] = []
        self._process = 0

    def record(self, record: AnyRecord, at_s: float) -> None:
        at_ns = kernel_ns(at_s)
        self.records.append((record, at_ns))
        self.validation.apply(record, at_ns)

    def judge(self, found: list[Judged], at_s: float) -> list[Judged]:
        for judged in found:
            self.record(judged, at_s)
        return found

    def admit(self, event_s: float, entity: str = "door", source: str = "s") -> int:
        """An event and its process; returns the process."""
        self._process += 1
        stamp = Stamp(source_ns=ns(event_s), received_ns=kernel_ns(event_s))
        event = Event(
            id=f"e{self._process}", kind="k", entity=entity, source=source, position=self._process, stamp=stamp, robot="r"
        )
        self.record(Admitted(event=event), event_s)
        self.record(Created(process=self._process, event=event.id, treatment="memory", criticality=0), event_s)
        return self._process

    def conclude(self, process: int, event_s: float, at_s: float, label: str = "none", entity: str = "") -> list[Judged]:
        record = Concluded(
            process=process,
            event=f"e{process}",
            treatment="memory",
            mode="auto",
            result=NOTHING,
            forecast=Forecast(label=label, probability=0.8, entity=entity),
            closes_ns=kernel_ns(event_s + WITHIN_S),
        )
        self.record(record, at_s)
        found = self.judge(self.validation.concluded(record.process), at_s)
        self.record(Moved(process=process, before=State.ACTIVE, trigger=Trigger.RESOLVE, after=State.COMPLETED), at_s)
        return found

    def forecast(self, event_s: float, label: str = "none", entity: str = "door", source: str = "s") -> int:
        """An event concluded at once."""
        process = self.admit(event_s, entity, source)
        self.conclude(process, event_s, event_s, label)
        return process

    def witness(self, outcome: Outcome, at_s: float | None = None) -> list[Judged]:
        at_s = outcome.at_ns / NS_PER_S if at_s is None else at_s
        self.record(Witnessed(outcome=outcome), at_s)
        return self.judge(self.validation.match(outcome, kernel_ns(at_s)), at_s)

    def close(self, at_s: float) -> list[Judged]:
        return self.judge(self.validation.close(kernel_ns(at_s)), at_s)

    def break_off(self, at_s: float, source: str = "") -> list[Judged]:
        return self.judge(self.validation.break_off(kernel_ns(at_s), source), at_s)

    def finish(self, at_s: float, source: str = "s") -> None:
        self.record(Finished(source=source, observations=1), at_s)

    def gain(self, judged: Judged, at_s: float = 0.0) -> Experience | None:
        experience = self.validation.experience(judged)
        if experience is not None:
            self.record(Gained(experience=experience), at_s)
        return experience


def outcome(id_: str, at_s: float, label: str = "intervention", entity: str = "door", **more: str | bool) -> Outcome:
    return Outcome(id=id_, topic="outcome", entity=entity, label=label, at_ns=ns(at_s), **more)  # type: ignore[arg-type]


def ns(seconds: float) -> int:
    return round(seconds * NS_PER_S)


def kernel_ns(source_s: float) -> int:
    return ns(source_s) + OFFSET_NS
