"""Observations, events, conditions and context: what the robot met."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from hashlib import blake2b
from typing import Literal

import msgspec

from wakeful.facts.time import Stamp
from wakeful.facts.values import Fact, Field, Value

Criticality = Literal[0, 1, 2, 3]
"""0 routine, 1 notable, 2 urgent, 3 critical: a critical event preempts."""

CRITICAL: Criticality = 3


class Observation(msgspec.Struct, frozen=True, kw_only=True):
    """What a sensor, bridge or log delivers, before registration. Never recorded as such.

    ``position`` counts from 0 within the source and is the source cursor; several observations never share one.
    """

    source: str
    position: int
    topic: str
    at_ns: int
    values: Mapping[str, Value]
    robot: str = ""
    clock: str = "source"
    uncertainty_ns: int = 0


class Undecodable(Fact, frozen=True):
    """An input that no observation could be made of; it counts as received and is refused with ``reason``."""

    source: str
    position: int
    reason: str
    excerpt: str = ""


class Relation(StrEnum):
    """How an event's entity stands to what was remembered of it."""

    NEW = "new"
    UNCHANGED = "unchanged"
    CHANGED = "changed"
    MOVED = "moved"


class Phase(StrEnum):
    """What an event does to a lasting condition. Repeats and clearings arrive as evidence, not as events."""

    RAISED = "raised"
    CHANGED = "changed"
    REPEATED = "repeated"
    CLEARED = "cleared"


class Condition(Fact, frozen=True):
    """What lasts. ``key`` is (robot, zone or site; source; type; references), joined by ``|``."""

    key: str
    phase: Phase


class Context(Fact, frozen=True):
    """Task state, spatial relations and recent history at the time of the event, c of Eq. 1."""

    task: str = ""
    zone: str = ""
    safety: bool = False
    fields: dict[str, Field] = {}


class Draft(Fact, frozen=True):
    """An event as registration offers it to admission: everything but its identity."""

    kind: str
    entity: str
    source: str
    position: int
    at_ns: int
    ordinal: int = 0
    robot: str = ""
    relation: Relation = Relation.CHANGED
    fields: dict[str, Field] = {}
    context: Context = Context()
    condition: Condition | None = None
    criticality: Criticality = 0
    deadline_s: float | None = None
    says: str = ""
    observations: int = 1
    clock: str = "source"
    uncertainty_ns: int = 0
    truth_treatment: str | None = None
    """The right treatment where the recording carries it: for accuracy only, never seen by selection."""


class Event(Fact, frozen=True):
    """A registered observation, e = D(o, c) (Eq. 1), with its identity. Once admitted it is owed coverage."""

    id: str
    kind: str
    entity: str
    source: str
    position: int
    stamp: Stamp
    ordinal: int = 0
    robot: str = ""
    relation: Relation = Relation.CHANGED
    fields: dict[str, Field] = {}
    context: Context = Context()
    condition: Condition | None = None
    criticality: Criticality = 0
    deadline_s: float | None = None
    says: str = ""
    observations: int = 1
    truth_treatment: str | None = None


def event_id(robot: str, digest: str, position: int, kind: str, ordinal: int) -> str:
    """The idempotency key: 20 hex digits of (robot, source digest or incarnation, position, kind, ordinal)."""
    key = "\x1f".join((robot, digest, str(position), kind, str(ordinal)))
    return blake2b(key.encode(), digest_size=10).hexdigest()
