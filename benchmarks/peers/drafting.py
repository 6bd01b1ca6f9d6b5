"""W's messages as a user of wakeful offers them."""

from __future__ import annotations

import msgspec

from benchmarks.peers.messages import Event
from benchmarks.peers.messages import Evidence as Reading
from benchmarks.peers.messages import Outcome as Shown
from benchmarks.peers.treating import TOPIC
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Evidence, Outcome


def draft(event: Event, source: str = "w", position: int = 0) -> Draft:
    """The event as a user of wakeful offers it."""
    return Draft(
        kind="object",
        entity=event.entity,
        source=source,
        position=position,
        at_ns=event.at_ns,
        fields={
            "category": event.category,
            "location": event.location,
            "state": event.state,
            "route": event.route,
            "load": event.load,
            "x": event.x,
            "y": event.y,
            "context": event.context,
        },
    )


def evidence(message: Reading) -> Evidence:
    """A reading as wakeful takes it."""
    value = msgspec.Raw(msgspec.json.encode(message.value))
    return Evidence(id=message.id, topic=TOPIC, key=message.entity, at_ns=message.at_ns, value=value)


def outcome(message: Shown) -> Outcome:
    """An outcome as wakeful takes it."""
    return Outcome(
        id=message.id,
        topic="outcome",
        entity=message.entity,
        label=message.label,
        at_ns=message.at_ns,
        acted_on=message.acted_on,
    )
