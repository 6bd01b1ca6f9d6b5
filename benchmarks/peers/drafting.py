"""An event of W as a user of wakeful offers it."""

from __future__ import annotations

from benchmarks.peers.messages import Event
from wakeful.facts.events import Draft


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
