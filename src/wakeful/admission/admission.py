"""Admission: an event becomes owed coverage, or is a duplicate, or is refused with a reason. Idempotent by event id."""

from __future__ import annotations

import math
import sys

import msgspec

from wakeful.admission.seen import Seen
from wakeful.facts.events import Draft, Event, Undecodable, event_id
from wakeful.facts.lines import Admitted, AnyRecord, Compacted, Duplicate, Refused
from wakeful.facts.time import LARGEST_NS, LONGEST_S, Stamp
from wakeful.facts.values import Field

#: A draft larger than this is not an event but a dump; it is refused and its source goes on.
MAX_EVENT_BYTES = 64 * 1024

_LARGEST = sys.float_info.max


class Counts(msgspec.Struct, frozen=True):
    """received = admitted + duplicate + refused, at every committed position."""

    admitted: int = 0
    duplicate: int = 0
    refused: int = 0

    @property
    def received(self) -> int:
        """Offered events and undecodable inputs."""
        return self.admitted + self.duplicate + self.refused


class Admission:
    """Knows which events were admitted. State changes only in ``apply`` and ``covered``.

    Args:
        keep_ids: so many of the newest are known, so that one of them that comes again is a duplicate.
    """

    def __init__(self, keep_ids: int = 250_000) -> None:
        self._seen = Seen(keep_ids)
        self._admitted = 0
        self._duplicate = 0
        self._refused = 0

    def admit(self, draft: Draft, digest: str, stamp: Stamp) -> Admitted | Duplicate | Refused:
        """What becomes of ``draft``, as the record to write.

        Args:
            draft: the event as registration offers it.
            digest: of its source's content, part of the event's identity.
            stamp: its times.
        """
        reason = _objection(draft)
        if reason:
            return Refused(source=draft.source, position=draft.position, reason=reason, excerpt=draft.kind[:80])
        identity = event_id(draft.robot, digest, draft.position, draft.kind, draft.ordinal)
        if identity in self._seen:
            return Duplicate(event=identity, source=draft.source, position=draft.position)
        event = Event(  # at most 15 arguments: Python makes a dictionary of more, which takes five times as long
            id=identity,
            kind=draft.kind,
            entity=draft.entity,
            source=draft.source,
            position=draft.position,
            stamp=stamp,
            robot=draft.robot,
            relation=draft.relation,
            fields=draft.fields,
            context=draft.context,
            condition=draft.condition,
            criticality=draft.criticality,
            deadline_s=draft.deadline_s,
            says=draft.says,
        )
        if draft.ordinal or draft.observations != 1 or draft.truth_treatment is not None:
            event = msgspec.structs.replace(
                event, ordinal=draft.ordinal, observations=draft.observations, truth_treatment=draft.truth_treatment
            )
        return Admitted(event=event)

    def reject(self, draft: Draft, reason: str) -> Refused:
        """An event that cannot be admitted for a reason that lies outside it."""
        return Refused(source=draft.source, position=draft.position, reason=reason, excerpt=draft.kind[:80])

    def refuse(self, undecodable: Undecodable) -> Refused:
        """An input that no observation could be made of."""
        return Refused(
            source=undecodable.source,
            position=undecodable.position,
            reason=undecodable.reason,
            unread=True,
            excerpt=undecodable.excerpt[:200],
        )

    def covered(self, event: str) -> None:
        """Count an admitted event, as ``apply`` does."""
        self._seen.add(event)
        self._admitted += 1

    def apply(self, record: AnyRecord) -> None:
        """Count what was recorded."""
        if isinstance(record, Admitted):
            self._seen.add(record.event.id)
            self._admitted += 1
        elif isinstance(record, Duplicate):
            self._duplicate += 1
        elif isinstance(record, Refused):
            self._refused += 1
        elif isinstance(record, Compacted):
            self._admitted += record.admitted
            self._duplicate += record.duplicate
            self._refused += record.refused

    def counts(self) -> Counts:
        """The conservation count at this position."""
        return Counts(self._admitted, self._duplicate, self._refused)


def _objection(draft: Draft) -> str:
    if not draft.kind:
        return "an event needs a kind"
    if not draft.entity:
        return "an event needs an entity: whom or what it is about"
    if draft.condition is not None and not draft.condition.key:
        return "a condition needs a key"
    if abs(draft.at_ns) > LARGEST_NS:
        return f"the instant {draft.at_ns} ns lies outside the years 1843 to 2096"
    if draft.criticality not in (0, 1, 2, 3):
        return f"criticality is {draft.criticality}; it must be 0, 1, 2 or 3"
    if draft.deadline_s is not None and not 0 < draft.deadline_s <= LONGEST_S:
        return f"deadline_s is {draft.deadline_s}; it must be a positive number of seconds, at most {LONGEST_S:g}"
    size = len(draft.says)
    for name, value in draft.fields.items():
        kind = value.__class__
        if kind is float:
            if not -_LARGEST <= value <= _LARGEST:  # type: ignore[operator]  # it is a float
                return _not_finite(name, value)
            size += len(name) + 8
        else:
            size += len(name) + (len(value) if isinstance(value, str | tuple) else 8)
    for name, value in draft.context.fields.items():
        if isinstance(value, float) and not math.isfinite(value):
            return _not_finite(name, value)
    if size > MAX_EVENT_BYTES:
        return f"the event has about {size} bytes; at most {MAX_EVENT_BYTES} are admitted, shorten its fields"
    return ""


def _not_finite(name: str, value: Field) -> str:
    return f"field {name!r} is {value}; numbers must be finite, leave the field out where it is unknown"
