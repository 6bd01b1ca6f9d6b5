"""The domain in which chaos is played: one kind of event for each way in which a treatment can go on, wait, ask or fail."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from types import MappingProxyType

import wakeful
from wakeful.contracts.treatment import Mind
from wakeful.domains.package import PackageDomain
from wakeful.facts.asking import Query, Question, Safety
from wakeful.facts.domain import DomainSpec, EvidenceSource, FieldSpec, Guideline, OutcomeSpec
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.treatments.registry import Registry

LABELS = ("none", "trouble", "worse")

#: The kinds of event; each is treated by the treatment of its name, but ``strange``, for which no guideline holds.
KINDS = ("described", "waits", "gathers", "calls", "effects", "nests", "dozes", "toils", "stumbles", "breaks", "strange")

WINDOW_S = 30.0

SPEC = DomainSpec(
    name="chaos",
    version=1,
    says="Events that are treated in every way there is.",
    fields={"heat": FieldSpec(low=0.0, high=1.0), "state": FieldSpec(values=("normal", "odd"))},
    outcome=OutcomeSpec(labels=LABELS, within_s=WINDOW_S),
    evidence=(EvidenceSource(topic="reading", channels=(), keep_s=20.0),),
    guideline=tuple(
        Guideline(treat="description" if kind == "described" else kind, because=f"it is {kind}", when={"kind": kind})
        for kind in KINDS[:-1]
    ),
    treatments=("description", *KINDS[1:-1]),
)


class Thought(Result, frozen=True, kw_only=True, tag="thought"):
    """What the treatments of this domain conclude: what they heard, in order."""

    heard: tuple[str, ...] = ()


@dataclasses.dataclass
class Outside:
    """Whom treatments call. ``does`` gives the answer to one call of (event, what, safety)."""

    does: Callable[[str, str, Safety], str]


def domain() -> PackageDomain:
    """The domain, without detectors: its events are registered elsewhere."""
    return PackageDomain(SPEC, MappingProxyType({}))


def registry(outside: Outside) -> Registry:
    """wakeful's own treatments, and those of this domain, which call ``outside``."""
    return Registry(own=_treatments(outside), installed=())


def _thought(event: Event, mind: Mind, *heard: str) -> Thought:
    return Thought(says=f"{event.kind} {event.entity}", confidence=0.8, forecast=mind.forecast(), heard=heard)


def _treatments(outside: Outside) -> tuple[wakeful.contracts.treatment.Treatment, ...]:
    @wakeful.treatment(says="Waits for one reading.")
    async def waits(event: Event, mind: Mind) -> Thought:
        await mind.work(2)
        came = await mind.evidence("reading", event.entity, within_s=8.0)
        await mind.work(1)
        return _thought(event, mind, *(each.id for each in came))

    @wakeful.treatment(says="Waits for two readings, then for one more.")
    async def gathers(event: Event, mind: Mind) -> Thought:
        came = await mind.evidence("reading", event.entity, within_s=10.0, count=2)
        await mind.work(1)
        more = await mind.evidence("reading", event.entity, within_s=5.0)
        return _thought(event, mind, *(each.id for each in (*came, *more)))

    @wakeful.treatment(says="Reads something outside, and does something twice harmlessly.")
    async def calls(event: Event, mind: Mind) -> Thought:
        await mind.work(1)
        read = await mind.call(lambda: outside.does(event.id, "look", "read"), key="look", within_s=10.0)
        await mind.work(2)
        done = await mind.call(
            lambda: outside.does(event.id, "note", "idempotent"), key="note", within_s=10.0, safety="idempotent"
        )
        return _thought(event, mind, str(read), str(done))

    @wakeful.treatment(says="Does what must not be done twice.")
    async def effects(event: Event, mind: Mind) -> Thought:
        await mind.work(1)
        try:
            done = await mind.call(lambda: outside.does(event.id, "act", "effect"), key="act", within_s=10.0, safety="effect")
        except wakeful.Refusal as refusal:
            done = f"refused: {refusal}"
        return _thought(event, mind, str(done))

    @wakeful.treatment(says="Has another treatment think about the same event, and about a part of it.")
    async def nests(event: Event, mind: Mind) -> Thought:
        child = await mind.treat("waits", event)
        await mind.work(1)
        other = await mind.treat("description", event)
        return _thought(event, mind, child.says, other.says)

    @wakeful.treatment(says="Sleeps, remembers, and asks a person who may not be there.")
    async def dozes(event: Event, mind: Mind) -> Thought:
        await mind.sleep_s(3.0)
        episodes = await mind.recall(Query(kind=event.kind, limit=3))
        said = await mind.ask(
            "operator", Question(about="what now", event=event.id, asks="What now?", options=("go", "stop")), 4.0
        )
        await mind.work(1)
        return _thought(event, mind, *(each.event for each in episodes), "nobody" if said is None else said.choice)

    @wakeful.treatment(says="Works long, and can be interrupted.")
    async def toils(event: Event, mind: Mind) -> Thought:
        for _ in range(5):
            await mind.work(4)
        return _thought(event, mind)

    @wakeful.treatment(says="Raises, unless it is provisional.")
    async def stumbles(event: Event, mind: Mind) -> Thought:
        await mind.work(1)
        if mind.mode != "fallback":
            raise RuntimeError("stumbled")
        return _thought(event, mind, "provisional")

    @wakeful.treatment(says="Raises whatever the mode.")
    async def breaks(event: Event, mind: Mind) -> Thought:
        await mind.work(1)
        await mind.evidence("reading", event.entity, within_s=2.0)
        raise RuntimeError("broken")

    return (waits, gathers, calls, effects, nests, dozes, toils, stumbles, breaks)
