"""What workload W sends: typed, validated JSON messages, decoded by the same code for every system."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Metres = Annotated[float, msgspec.Meta(ge=-2.5, le=2.5)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]

CATEGORIES = ("item", "obstacle", "unknown", "device")
LOCATIONS = ("center", "edge", "route", "storage")
STATES = ("normal", "unstable", "abnormal")
ROUTES = ("none", "outside", "blocking")
CONTEXTS = ("none", "task", "safety")
TREATMENTS = ("description", "memory", "risk_prediction", "planning", "diagnosis", "analogy")
LABELS = ("none", "intervention")

Label = Literal["none", "intervention"]


class Message(msgspec.Struct, frozen=True, tag_field="is", tag=str.lower, forbid_unknown_fields=True):
    """Base of every message; ``at_ns`` is workload time."""

    at_ns: int


class Event(Message, frozen=True):
    """One encounter of the service robot: eight fields, of an entity that is met once."""

    entity: Name
    category: Literal["item", "obstacle", "unknown", "device"]
    location: Literal["center", "edge", "route", "storage"]
    state: Literal["normal", "unstable", "abnormal"]
    route: Literal["none", "outside", "blocking"]
    load: Share
    x: Metres
    y: Metres
    context: Literal["none", "task", "safety"]


class Evidence(Message, frozen=True):
    """A reading of a device, for who waits for it; the same id sent twice counts once."""

    id: Name
    entity: Name
    value: float


class Outcome(Message, frozen=True):
    """What the world later showed of an event."""

    id: Name
    entity: Name
    label: Label
    acted_on: bool = False


class Tick(Message, frozen=True):
    """Workload time goes on: what waited beyond its limit goes on without what it waited for."""


AnyMessage = Event | Evidence | Outcome | Tick

decode = msgspec.json.Decoder(AnyMessage).decode
encode = msgspec.json.Encoder().encode
