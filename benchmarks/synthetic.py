"""Synthetic events as the entries that a kernel gives: for journals of any length, made in no time."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import blake2b
from random import Random

import msgspec

from wakeful.facts.choices import Basis, Choice
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event, event_id
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.lines import (
    Admitted,
    AnyRecord,
    Concluded,
    Created,
    Decided,
    Judged,
    Line,
    Moved,
    Opened,
    Published,
    TrainingAsked,
)
from wakeful.facts.packs import AnyBurst, Covered, Entry, Pack, Ran, Validated
from wakeful.facts.processes import State, Trigger
from wakeful.facts.time import Stamp
from wakeful.facts.values import Raw

OPEN_ONE_IN, DEBT_ONE_IN, MODEL_ONE_IN = 2_000, 2_000, 50_000

LABELS = ("none", "intervention")
TREATMENTS = ("analogy", "description", "diagnosis", "memory", "planning", "risk_prediction")
_RESULT = Raw(
    b'{"type":"description","says":"as usual; expect none (98 %).","confidence":0.9,'
    b'"forecast":{"label":"none","probability":0.98}}'
)


class Stream:
    """Entries of synthetic events, as a kernel would have them committed; one in so many stays open, or brings a new model."""

    def __init__(
        self, days: float, events: int, seed: int, open_one_in: int = OPEN_ONE_IN, model_one_in: int = MODEL_ONE_IN
    ) -> None:
        self._open_one_in, self._model_one_in = open_one_in, model_one_in
        self._draw = Random(seed)
        self._spacing_ns = int(days * 86_400e9 / events)
        self._position = 0
        self._number = 0
        self._experience = 0
        self._model = 0
        self.kept: dict[int, list[Line]] = {}
        """What must still be there at the end: the lines of open processes and of debt, and of published models."""
        self.open = self.debt = 0
        self.blobs: dict[str, bytes] = {}
        self._basis: Basis | None = None

    def begin(self) -> list[Entry]:
        """The opening of the source."""
        return [
            self._line(Opened(source="robot", digest="growth", domain="service_robot", domain_version=1, offset_ns=0, seed=0))
        ]

    def next(self) -> Iterator[Entry]:
        """One more event, wholly treated and judged, or open, or in debt."""
        self._number += 1
        number = self._number
        event = self._event(number)
        if number % self._model_one_in == 0:
            self._model += 1
            yield from self._published()
        if number % self._open_one_in == 7:
            self.open += 1
            yield self._keep(self._pack(self._covered(event)))
        elif number % DEBT_ONE_IN == 11:
            self.debt += 1
            for record in self._fallback(event):
                yield self._keep(self._line(record))
        else:
            yield self._pack(self._covered(event))
            yield self._pack(
                Ran(
                    process=number,
                    event=event.id,
                    before=State.CREATED,
                    steps_before=0,
                    steps=3,
                    treatment="description",
                    mode="auto",
                    result=_RESULT,
                    closes_ns=self._at_ns + 30_000_000_000,
                )
            )
            yield self._pack(self._judged(event))

    @property
    def _at_ns(self) -> int:
        return self._number * self._spacing_ns

    def _line(self, record: AnyRecord) -> Line:
        self._position += 1
        return Line(self._position, self._at_ns, record)

    def _pack(self, burst: AnyBurst) -> Pack:
        pack = Pack(self._position + 1, self._at_ns, burst)
        self._position = pack.last
        return pack

    def _keep(self, entry: Entry) -> Entry:
        lines = list(entry.lines()) if isinstance(entry, Pack) else [entry]
        self.kept.setdefault(self._number, []).extend(lines)
        return entry

    def _event(self, number: int) -> Event:
        draw = self._draw.random()
        return Event(
            id=event_id("", "growth", number, "object", 0),
            kind="object",
            entity=f"item-{number % 997:04d}",
            source="robot",
            position=number,
            stamp=Stamp(source_ns=self._at_ns, received_ns=self._at_ns),
            fields={
                "category": "item" if draw < 0.5 else "obstacle",
                "location": "center",
                "state": "normal",
                "route": "outside",
                "load": round(draw, 3),
                "x": round(5 * draw - 2.5, 2),
                "y": round(2.5 - 5 * draw, 2),
                "context": "safety",
            },
        )

    def _covered(self, event: Event) -> Covered:
        share = round(0.9 + 0.09 * self._draw.random(), 6)
        rests_on = tuple(max(1, self._experience - self._draw.randrange(10_000)) for _ in range(3)) if self._experience else ()
        choice = Choice(
            basis=self._basis or self._new_basis(),
            shares=(0.01, share, 0.01, 0.01, 0.01, 0.01),
            prior=(0.98, 0.02),
            novelty=round(share / 3, 6),
            trust=0.8,
            rests_on=rests_on,
        )
        return Covered(event=event, process=event.position, choice=choice)

    def _new_basis(self) -> Basis:
        self._basis = Basis(
            treatment="description",
            model=self._model,
            watermark=self._experience,
            treatments=TREATMENTS,
            labels=LABELS,
            threshold=0.6,
            result_threshold=0.5,
            novelty_limit=0.99,
            trust_limit=0.4,
            support=100,
        )
        return self._basis

    def _judged(self, event: Event) -> Validated:
        self._experience += 1
        label = LABELS[0]
        return Validated(
            outcome=Outcome(
                id=event_id("", "o", event.position, "", 0),
                topic="outcome",
                entity=event.entity,
                label=label,
                at_ns=self._at_ns + 1,
                event=event.id,
            ),
            judged=Judged(
                process=event.position,
                event=event.id,
                predicted=label,
                label=label,
                verdict=Verdict.SUPPORTED,
                outcome=event_id("", "o", event.position, "", 0),
            ),
            experience=Experience(
                id=self._experience,
                event=event.id,
                process=event.position,
                treatment="description",
                treatment_label="description",
                predicted=label,
                outcome=label,
                verdict=Verdict.SUPPORTED,
                mode="auto",
            ),
        )

    def _fallback(self, event: Event) -> Iterator[AnyRecord]:
        process = event.position
        decision: Decision = msgspec.structs.replace(self._covered(event).choice.decision(), mode="fallback")
        yield Admitted(event=event)
        yield Created(process=process, event=event.id, treatment=decision.treatment, criticality=0)
        yield Decided(process=process, event=event.id, decision=decision)
        yield Moved(process=process, before=State.CREATED, trigger=Trigger.DISPATCH, after=State.ACTIVE)
        yield Concluded(process=process, event=event.id, treatment=decision.treatment, mode="fallback", result=_RESULT)
        yield Moved(process=process, before=State.ACTIVE, trigger=Trigger.RESOLVE, after=State.COMPLETED, steps=3)

    def _published(self) -> Iterator[Entry]:
        number, base, watermark = self._model, self._model - 1, self._experience
        asked = TrainingAsked(training=number, base=base, watermark=watermark, seed=number, epochs=35, publish_ns=self._at_ns)
        yield self._keep(self._line(asked))
        weights = f"weights of version {number}".encode()
        name = blake2b(weights, digest_size=16).hexdigest()
        self.blobs[name] = weights
        card = ModelCard(version=number, base=base, watermark=watermark, seed=number, epochs=35, blob=name, accepted=True)
        yield self._keep(self._line(Published(training=number, card=card)))
        self._basis = None
