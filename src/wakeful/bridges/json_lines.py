"""The JSON that the ``jsonl`` bridge reads: one object a line, in the schema of docs/jsonl.md, or any object at all."""

from __future__ import annotations

import json
from collections.abc import Mapping
from hashlib import blake2b
from typing import Final

import msgspec

from wakeful.bridges.instants import instant_ns
from wakeful.bridges.plain import plain
from wakeful.bridges.vda5050 import topic_of
from wakeful.contracts.bridge import Item
from wakeful.facts.events import Condition, Context, Criticality, Draft, Observation, Phase, Relation
from wakeful.facts.evidence import Evidence, Origin, Outcome
from wakeful.facts.time import LONGEST_S, NS_PER_S, to_ns
from wakeful.facts.values import Field, Value

At = str | int | float
"""ISO 8601, or a number of seconds, milli-, micro- or nanoseconds since 1970 (told apart by its size)."""

_TIME_NAMES: Final = ("timestamp", "at", "time")
_MAX_ID_CHARS: Final = 200
_MISSPELT_LETTERS: Final = 2


class Said(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of what stands under a line's one key. Without ``at`` it is one second after the line before it."""

    at: At | None = None


class ObservationSaid(Said, frozen=True, kw_only=True):
    """``{"observation": …}``: what a sensor delivers, for the domain to register. ``uncertainty_s`` is that of the clock."""

    topic: str
    values: dict[str, object]
    robot: str = ""
    clock: str = "source"
    uncertainty_s: float = 0.0


class ContextSaid(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What surrounds an event."""

    task: str = ""
    zone: str = ""
    safety: bool = False
    fields: dict[str, Field] = {}


class ConditionSaid(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The lasting condition that an event raises, changes, repeats or clears."""

    key: str
    phase: Phase


class EventSaid(Said, frozen=True, kw_only=True):
    """``{"event": …}``: an event that somebody else has registered already. ``deadline_s`` counts from its time."""

    kind: str
    entity: str
    robot: str = ""
    relation: Relation = Relation.CHANGED
    fields: dict[str, Field] = {}
    context: ContextSaid = ContextSaid()
    condition: ConditionSaid | None = None
    criticality: Criticality = 0
    deadline_s: float | None = None
    says: str = ""
    observations: int = 1
    truth_treatment: str | None = None


class EvidenceSaid(Said, frozen=True, kw_only=True):
    """``{"evidence": …}``: later information, for whoever asked by topic and key. The same ``id`` twice counts once."""

    topic: str
    key: str
    value: object = None
    id: str = ""
    origin: Origin = "world"


class OutcomeSaid(Said, frozen=True, kw_only=True):
    """``{"outcome": …}``: what the world showed about an entity (``*``: the whole robot), or about one event by its id."""

    label: str
    topic: str = "outcome"
    entity: str = "*"
    event: str = ""
    treatment: str = ""
    id: str = ""
    acted_on: bool = False
    origin: Origin = "world"


class ObservationLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line that carries an observation."""

    observation: ObservationSaid


class EventLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line that carries an event."""

    event: EventSaid


class EvidenceLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line that carries evidence."""

    evidence: EvidenceSaid


class OutcomeLine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line that carries an outcome."""

    outcome: OutcomeSaid


LINES: Final[dict[str, type[ObservationLine | EventLine | EvidenceLine | OutcomeLine]]] = {
    "observation": ObservationLine,
    "event": EventLine,
    "evidence": EvidenceLine,
    "outcome": OutcomeLine,
}


class Refused(ValueError):
    """A line that nothing can be made of; the message says why."""


def item_of(text: bytes, source: str, position: int, before_ns: int) -> tuple[Item, int]:
    """What one line (or one file) says, and its time.

    Args:
        text: a JSON object.
        before_ns: the time of the line before it; one without a time of its own is a second later.

    Raises:
        Refused: it is not JSON, no object, or not in the schema.
    """
    said = _object(text)
    word = next(iter(said)) if len(said) == 1 else ""
    if word not in LINES:
        if word and isinstance(said[word], Mapping) and (meant := _misspelt(word)):
            raise Refused(f"not a line of the schema: `{word}` is none of {', '.join(LINES)}; did you mean `{meant}`?")
        return _message(said, source, position, before_ns)
    if not isinstance(said[word], Mapping):
        raise Refused(f"not a line of the schema: `{word}` must hold an object, not {_shown(said[word])}")
    try:
        line = msgspec.convert(said, LINES[word])
        return _item(line, text, source, position, before_ns)
    except (msgspec.ValidationError, ValueError, OverflowError) as failure:
        raise Refused(f"not a line of the schema: {failure}") from failure


def _misspelt(word: str) -> str:
    """Which of the four a word was meant to be: the first within two letters of it; empty where none is."""
    return next((name for name in LINES if _distance(word.lower(), name) <= _MISSPELT_LETTERS), "")


def _distance(one: str, other: str) -> int:
    """How many letters must be added, left out or changed to make one word of the other."""
    if abs(len(one) - len(other)) > _MISSPELT_LETTERS:
        return _MISSPELT_LETTERS + 1
    before = list(range(len(other) + 1))
    for row, letter in enumerate(one, 1):
        now = [row]
        for column, against in enumerate(other, 1):
            now.append(min(before[column] + 1, now[-1] + 1, before[column - 1] + (letter != against)))
        before = now
    return before[-1]


def _shown(value: Value) -> str:
    return json.dumps(value, default=str)[:40]


def _object(text: bytes) -> dict[str, Value]:
    try:
        value = msgspec.json.decode(text)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
        value = _lenient(text)
    try:
        found = plain(value)
    except ValueError as failure:
        raise Refused(str(failure)) from failure
    if not isinstance(found, Mapping):
        raise Refused(f"a JSON {type(value).__name__}, not an object")
    return dict(found)


def _lenient(text: bytes) -> object:
    """JSON as many programs write it, with NaN and Infinity. Raises Refused."""
    try:
        return json.loads(text.decode("utf-8"), parse_constant=lambda _: None)
    except UnicodeDecodeError as failure:
        raise Refused(f"not UTF-8: {failure.reason} at byte {failure.start}") from failure
    except RecursionError as failure:
        raise Refused("nested too deep") from failure
    except ValueError as failure:
        raise Refused(f"not JSON: {failure}") from failure


def _item(
    line: ObservationLine | EventLine | EvidenceLine | OutcomeLine, text: bytes, source: str, position: int, before_ns: int
) -> tuple[Item, int]:
    if isinstance(line, ObservationLine):
        return _observation(line.observation, source, position, before_ns)
    if isinstance(line, EventLine):
        return _draft(line.event, source, position, before_ns)
    fresh = f"{blake2b(text.strip(), digest_size=8).hexdigest()}-{position}"
    if isinstance(line, EvidenceLine):
        evidence = line.evidence
        at_ns, _ = _at(evidence.at, before_ns)
        value = msgspec.Raw(msgspec.json.encode(evidence.value))
        id_ = evidence.id[:_MAX_ID_CHARS] or fresh
        return Evidence(id=id_, topic=evidence.topic, key=evidence.key, at_ns=at_ns, value=value, origin=evidence.origin), at_ns
    outcome = line.outcome
    at_ns, _ = _at(outcome.at, before_ns)
    return Outcome(
        id=outcome.id[:_MAX_ID_CHARS] or fresh,
        topic=outcome.topic,
        entity=outcome.entity,
        label=outcome.label,
        at_ns=at_ns,
        event=outcome.event,
        treatment=outcome.treatment,
        acted_on=outcome.acted_on,
        origin=outcome.origin,
    ), at_ns


def _observation(said: ObservationSaid, source: str, position: int, before_ns: int) -> tuple[Item, int]:
    at_ns, clock = _at(said.at, before_ns)
    return Observation(
        source=source,
        position=position,
        topic=said.topic,
        at_ns=at_ns,
        values={name: plain(value) for name, value in said.values.items()},
        robot=said.robot,
        clock=clock or said.clock,
        uncertainty_ns=to_ns(min(max(0.0, said.uncertainty_s), LONGEST_S)),
    ), at_ns


def _draft(said: EventSaid, source: str, position: int, before_ns: int) -> tuple[Item, int]:
    at_ns, clock = _at(said.at, before_ns)
    return Draft(
        kind=said.kind,
        entity=said.entity,
        source=source,
        position=position,
        at_ns=at_ns,
        robot=said.robot,
        relation=said.relation,
        fields=said.fields,
        context=Context(**msgspec.structs.asdict(said.context)),
        condition=Condition(key=said.condition.key, phase=said.condition.phase) if said.condition else None,
        criticality=said.criticality,
        deadline_s=said.deadline_s,
        says=said.says,
        observations=max(1, said.observations),
        clock=clock or "source",
        truth_treatment=said.truth_treatment,
    ), at_ns


def _message(said: dict[str, Value], source: str, position: int, before_ns: int) -> tuple[Item, int]:
    """Any other object: an observation whose values are the whole of it."""
    stamps = (instant_ns(said[name]) for name in _TIME_NAMES if name in said)
    stamp = next((at_ns for at_ns in stamps if at_ns is not None), None)
    at_ns = before_ns + NS_PER_S if stamp is None else stamp
    standard = topic_of(said)
    named = said.get("topic")
    robot = said.get("serialNumber") if standard else said.get("robot")
    return Observation(
        source=source,
        position=position,
        topic=standard or (named if isinstance(named, str) and named else "message"),
        at_ns=at_ns,
        values=said,
        robot=robot if isinstance(robot, str) else "",
        clock="line" if stamp is None else "source",
    ), at_ns


def _at(at: At | None, before_ns: int) -> tuple[int, str]:
    """The instant, and ``line`` as the clock where there was none."""
    if at is None:
        return before_ns + NS_PER_S, "line"
    if (at_ns := instant_ns(at)) is None:
        raise Refused(f"`at` is no instant: {at!r}; write ISO 8601 or seconds since 1970")
    return at_ns, ""
