"""Evidence that the domain offers: what can be asked for about an event, how long there is, and what an answer says."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase

import msgspec

from wakeful.contracts.treatment import Mind
from wakeful.facts.domain import DomainSpec, EvidenceSource
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.time import to_s
from wakeful.facts.values import Fact, Field
from wakeful.treatments.measures import number
from wakeful.treatments.wording import bare, brief

#: Without a deadline a treatment waits at most so long.
PATIENCE_S = 60.0

#: It spends at most this part of what is left before the deadline, and of the window in which the outcome will show: a result
#: that comes after its outcome forecasts nothing.
PATIENCE_SHARE = 0.5

_NUMBER = re.compile(r"\d+")


class Askable(Fact, frozen=True):
    """Evidence that can be asked for: its address, how often it comes, the channel it is made of and what its value names."""

    topic: str
    key: str
    every_s: float
    channel: str = ""
    names: tuple[str, ...] = ()

    @property
    def address(self) -> str:
        """Topic and key as a person reads them."""
        return f"{brief(self.topic)}/{brief(self.key)}"


def askable(domain: DomainSpec, event: Event) -> tuple[Askable, ...]:
    """The evidence that concerns the event, by the domain's evidence sources.

    Of a source's channels these concern the event: its own (the field ``channel``, or the entity where that is a channel), the
    one that a pattern names of a numbered entity, and every channel without ``*``. A source without channels
    is offered by a detector of the domain's own, and is keyed by the entity.
    """
    found: dict[tuple[str, str], Askable] = {}
    for source in domain.evidence:
        for channel in _channels(source, event) if source.channels else ("",):
            key = _filled(source.key, channel, event.robot or domain.robot) if channel else event.entity
            names = source.fields or (channel.rpartition("/")[2],)
            offer = Askable(topic=source.topic, key=key, every_s=max(source.every_s, 0.0), channel=channel, names=names)
            found.setdefault((source.topic, key), offer)
    return tuple(found.values())


def about(offers: Iterable[Askable], field: str) -> tuple[Askable, ...]:
    """The offers that answer for a field: those that name it, or whose name holds the field's bare name.

    >>> offers = [Askable(topic="t", key="k", every_s=1.0, names=("Current_J3",))]
    >>> len(about(offers, "current_a")), len(about(offers, "tilt_deg"))
    (1, 0)
    """
    word = bare(field).replace(" ", "_").casefold()
    return tuple(offer for offer in offers if word and any(_answers(name.casefold(), field, word) for name in offer.names))


def slack_s(event: Event, mind: Mind) -> float | None:
    """Seconds left until the event's deadline by kernel time, never below zero; None where it has no deadline."""
    if event.deadline_s is None or number(event.deadline_s) is None:
        return None
    return max(to_s(event.stamp.received_ns) + event.deadline_s - mind.now_s, 0.0)


def patience_s(event: Event, mind: Mind, offer: Askable) -> float:
    """How long to wait for this evidence; 0 where it comes too seldom for that, so that it is not asked for."""
    left = slack_s(event, mind)
    gone_s = max(mind.now_s - to_s(event.stamp.received_ns), 0.0)
    window_s = max(mind.domain.outcome.within_s - gone_s, 0.0)
    longest = min(PATIENCE_S, PATIENCE_SHARE * window_s, PATIENCE_S if left is None else PATIENCE_SHARE * left)
    return longest if longest >= offer.every_s and longest > 0.0 else 0.0


def reading(evidence: Evidence, name: str = "") -> Field:
    """What a piece of evidence says: its value, or of an object the member ``name``, ``value`` or ``mean``; None if neither."""
    try:
        value: object = msgspec.json.decode(evidence.value)
    except msgspec.DecodeError:
        return None
    if isinstance(value, dict):
        value = next((value[member] for member in (name, "value", "mean") if member in value), None)
    if isinstance(value, bool | str):
        return value
    return number(value)


def _channels(source: EvidenceSource, event: Event) -> Iterator[str]:
    own = [name for name in (event.fields.get("channel"), event.entity) if isinstance(name, str)]
    for pattern in source.channels:
        if "*" not in pattern:
            yield pattern
            continue
        named = [name for name in own if fnmatchcase(name, pattern)]
        yield from named or _of_part(pattern, event.entity)


def _of_part(pattern: str, entity: str) -> Iterator[str]:
    """The channel of a numbered part: ``row/Current_J*`` or ``row/Temperature_*`` of ``J3``. A ``*`` in the topic stays open."""
    before, _, after = pattern.partition("*")
    digits = _NUMBER.findall(entity)[-1:]
    if digits and "/" in before and "*" not in after:
        yield before + (digits[0] if before[-1:].isalpha() else entity) + after


def _filled(template: str, channel: str, robot: str) -> str:
    topic, _, name = channel.rpartition("/")
    digits = (_NUMBER.findall(name) or [""])[-1]
    for word, value in (("channel", channel), ("topic", topic), ("name", name), ("robot", robot), ("number", digits)):
        template = template.replace(f"{{{word}}}", value)
    return template


def _answers(name: str, field: str, word: str) -> bool:
    return name == field.casefold() or (len(word) > 2 and word in name)
