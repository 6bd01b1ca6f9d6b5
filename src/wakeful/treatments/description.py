"""Description: what is there, in a typed scene entry and one sentence. What most events get."""

from __future__ import annotations

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event, Relation
from wakeful.facts.results import Result
from wakeful.facts.values import Fact, Field
from wakeful.treatments.consulting import consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import expectation, forecast_reasons, pooled, recalled_voice
from wakeful.treatments.measures import number, plain
from wakeful.treatments.remembering import age_s, of_entity, resting, same, similar, typical
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.wording import ago, brief, counted, subject, valued, worded

#: How many sightings or like cases tell what is normal here.
SIGHTINGS = 8

#: How many attributes the sentence names; the scene entry has them all.
NAMED = 3


class Attribute(Fact, frozen=True):
    """One attribute as it is, as it usually is here, and whether the two agree (None: nothing to compare with)."""

    name: str
    value: Field
    usual: Field = None
    as_usual: bool | None = None


class SceneEntry(Fact, frozen=True):
    """One thing in the scene: what, where, how it stands to what was remembered, and its attributes."""

    entity: str
    kind: str
    relation: Relation
    zone: str = ""
    task: str = ""
    attributes: tuple[Attribute, ...] = ()
    sightings: int = 0
    """How many recalled cases "usual" was taken from."""
    usual_of: str = ""
    """Whose usual it is: the entity's own, or that of like cases."""


class Notable(Fact, frozen=True):
    """A reasoner's pick: the attributes that are worth saying first."""

    attributes: tuple[str, ...]


class Description(Result, frozen=True, kw_only=True, tag="description"):
    """What is there, and what is normal here."""

    scene: SceneEntry


@treatment(
    "description",
    result=Description,
    says="Describes what is there and what is normal here; for events that are familiar and harmless.",
)
async def description(event: Event, mind: Mind) -> Description:
    """Register what is there as a typed scene entry, compare it with what is usual, and say it in one sentence."""
    await mind.work(1)
    own = event.relation is not Relation.NEW
    past = await (of_entity(event, mind, SIGHTINGS, event.kind) if own else similar(event, mind, SIGHTINGS))
    attributes = tuple(
        _attribute(name, value, [e.fields[name] for e in past if name in e.fields], mind.domain)
        for name, value in event.fields.items()
    )
    odd = [attribute for attribute in attributes if attribute.as_usual is False]
    names = {attribute.name for attribute in attributes}
    said = await consult(
        event,
        mind,
        "description",
        f"Which attributes of this scene are most worth saying, at most {NAMED}, the most important first?",
        Notable,
        lambda notable: _unsayable(notable, names),
        past,
        sorted(names),
    )
    if said.answer is not None:
        order = {name: place for place, name in enumerate(said.answer.attributes)}
        attributes = tuple(sorted(attributes, key=lambda attribute: order.get(attribute.name, len(order))))
    voice = recalled_voice(mind, event, past, ranked=not own)
    forecast = pooled(mind, event, [voice])
    scene = SceneEntry(
        entity=brief(event.entity),
        kind=event.kind,
        relation=event.relation,
        zone=brief(event.context.zone),
        task=brief(event.context.task),
        attributes=attributes,
        sightings=len(past),
        usual_of="" if not past else "its own" if own else "like cases",
    )
    compared = [attribute for attribute in attributes if attribute.as_usual is not None]
    # being sure of a description grows with what it could be compared with
    confidence = 0.5 + 0.4 * len(compared) / len(attributes) if attributes else NOTHING_TO_GO_ON
    usual = f"what {scene.entity} is usually like" if own else f"what a {event.kind} is usually like"
    return Description(
        says=sentence(
            mind,
            subject(event),
            _what(event, scene),
            _shown(event, attributes, odd),
            _beside(event, scene, odd, past),
            expectation(forecast),
        ),
        confidence=sure(mind, confidence),
        rests_on=(f"event {event.id}", *resting(past), *forecast_reasons(mind, [voice]), *said.basis),
        would_change=(
            *(f"{worded(a.name, a.usual)}, as usual" for a in odd),
            *(() if past else (f"sightings that show {usual}",)),
        )
        or ("a value outside what is usual here",),
        forecast=forecast,
        consulted=said.consulted,
        scene=scene,
    )


def _attribute(name: str, value: Field, past: list[Field], domain: DomainSpec) -> Attribute:
    # a vector has no usual value; numbers and words do
    usual = None if isinstance(value, tuple) else typical(past)
    as_usual = (
        None
        if usual is None
        else same(name, value, usual, domain.fields) or any(same(name, value, each, domain.fields) for each in past)
    )
    if number(value) is not None and as_usual is False:
        known = [each for each in (number(item) for item in past) if each is not None]
        as_usual = bool(known) and min(known) <= (number(value) or 0.0) <= max(known)
    return Attribute(name=name, value=plain(value), usual=usual, as_usual=as_usual)


def _unsayable(notable: Notable, names: set[str]) -> str:
    unknown = [name for name in notable.attributes if name not in names]
    if unknown:
        return f"the event has no attribute {unknown[0][:60]!r}"
    return (
        ""
        if 1 <= len(notable.attributes) <= NAMED
        else f"it names {len(notable.attributes)} attributes, 1 to {NAMED} were asked for"
    )


def _what(event: Event, scene: SceneEntry) -> str:
    where = f" in {scene.zone}" if scene.zone else ""
    stands = {Relation.UNCHANGED: "as it was", Relation.NEW: "new"}.get(event.relation, event.relation.value)
    return f"{stands}{where}{', safety at stake' if event.context.safety else ''}"


def _shown(event: Event, attributes: tuple[Attribute, ...], odd: list[Attribute]) -> str:
    if event.says:
        # registration has said it already, with the numbers that matter
        return ""
    # what is unusual is said first, or the sentence would bury it
    first = [*odd, *(attribute for attribute in attributes if attribute not in odd)]
    told = [attribute for attribute in first if attribute.value is not None][:NAMED]
    more = len(attributes) - len(told)
    listed = ", ".join(worded(attribute.name, attribute.value) for attribute in told)
    return f": {listed}" + (f" and {more} more" if more > 0 else "") if told else ""


def _beside(event: Event, scene: SceneEntry, odd: list[Attribute], past: tuple[Episode, ...]) -> str:
    if not past:
        return "; nothing like it is remembered"
    of = "sighting" if scene.usual_of == "its own" else "like case"
    seen = f"; {counted(len(past), of)} recalled, the last {ago(age_s(event, past[0]))}"
    if not odd:
        return seen + ", all as usual" if scene.attributes else seen
    return seen + ", unusual: " + ", ".join(f"{worded(a.name, a.value)} (usually {valued(a.name, a.usual)})" for a in odd[:NAMED])
