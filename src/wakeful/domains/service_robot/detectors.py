"""What of a tour is worth an event: an object that is new, that stands elsewhere, or that is no longer as it was."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot

import msgspec

from wakeful.contracts.detector import DetectorFactory, Found, Offered, Shown
from wakeful.domains.plain import flag, number, text
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Field, Value

KEPT = 5_000
"""Objects remembered; the one not seen for longest is forgotten first, and is new when it comes back."""


class Standing(msgspec.Struct):
    """An object as it was last registered, and how often it was seen unchanged since. Its position stays the registered one
    until it was moved: what wavers is no change of place."""

    place: str
    x: float
    y: float
    state: str
    route: str
    load: float
    repeats: int = 0


class Objects(msgspec.Struct):
    """All objects by identity, the one not seen for longest first."""

    standing: dict[str, Standing] = {}


class Sightings(Remembering[Objects]):
    """Registers an object when it is first seen, when it was moved, and when its state, its relation to the route or its
    load changed. Seeing it again as it was is no event."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        del domain
        super().__init__(Objects())
        self._moved_m = _setting(spec, "moved_m", 0.5)
        self._load_change = _setting(spec, "load_change", 0.1)

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """One sighting of one object; other topics and objects without a name are passed over."""
        values = observation.values
        identity = text(values, "identity")
        x, y = number(values, "x"), number(values, "y")
        if observation.topic != "sighting" or not identity or x is None or y is None:
            return
        now = Standing(
            place=text(values, "place"),
            x=x,
            y=y,
            state=text(values, "state"),
            route=text(values, "route"),
            load=number(values, "load") or 0.0,
        )
        before = self.memory.standing.pop(identity, None)
        if before is not None:
            moved = before.place != now.place or hypot(now.x - before.x, now.y - before.y) >= self._moved_m
            if not moved:
                now.x, now.y = before.x, before.y
            if not moved and not self._differs(before, now):
                before.repeats += 1
                self.memory.standing[identity] = before
                return
        self.memory.standing[identity] = now
        while len(self.memory.standing) > KEPT:
            del self.memory.standing[next(iter(self.memory.standing))]
        yield self._found(identity, now, before, observation)

    def _differs(self, before: Standing, now: Standing) -> bool:
        return (before.state, before.route) != (now.state, now.route) or abs(now.load - before.load) >= self._load_change

    def _found(self, identity: str, now: Standing, before: Standing | None, observation: Observation) -> Found:
        values = observation.values
        context, task = text(values, "context"), text(values, "task")
        fields: dict[str, Field] = {
            "category": text(values, "category") or "unknown",
            "location": text(values, "location"),
            "state": now.state,
            "route": now.route,
            "load": now.load,
            "context": context or "none",
            "position": (now.x, now.y),
        }
        return Found(
            entity=identity,
            zone=now.place,
            task=task,
            safety=context == "safety",
            fields=fields,
            says=_sentence(identity, now, before),
            criticality=(criticality := _criticality(fields)),
            deadline_s={3: 10.0, 2: 30.0}.get(criticality),
            observations=1 + (before.repeats if before is not None else 0),
            truth_treatment=text(values, "truth_treatment") or None,
        )


class Nothing(msgspec.Struct):
    """The memory of a detector that needs none."""


class Reports(Remembering[Nothing]):
    """Hears what an encounter turned out to need, and the later readings of devices."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        del spec
        super().__init__(Nothing())
        self._labels = domain.outcome.labels

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """One report or reading; a report whose word the domain does not know is passed over."""
        values = observation.values
        identity = text(values, "identity")
        if not identity:
            return
        if observation.topic == "report" and (needed := text(values, "needed")) in self._labels:
            about = values.get("about")
            position = about if isinstance(about, int) and not isinstance(about, bool) else None
            yield Shown(label=needed, entity=identity, event_position=position, acted_on=bool(flag(values, "acted_on")))
        elif observation.topic == "reading":
            measured: dict[str, Value] = {name: value for name, value in values.items() if name != "identity"}
            yield Offered(topic="reading", key=identity, value=measured)


def _sentence(identity: str, now: Standing, before: Standing | None) -> str:
    where = f"at {now.place.replace('_', ' ')}" if now.place else "at an unnamed place"
    if before is None:
        return f"{identity}, not seen before, stands {where}: {now.state}, {_way(now.route)}"
    changes = []
    if before.place != now.place:
        changes.append(f"was moved from {before.place.replace('_', ' ')}")
    elif (distance_m := hypot(now.x - before.x, now.y - before.y)) >= 0.1:
        changes.append(f"was moved by {distance_m:.1f} m")
    if before.state != now.state:
        changes.append(f"went from {before.state} to {now.state}")
    if before.route != now.route:
        changes.append(f"now stands {_way(now.route)}")
    if abs(now.load - before.load) >= 0.1:
        changes.append(f"carries {now.load:.0%} of its capacity instead of {before.load:.0%}")
    return f"{identity} {where} {', '.join(changes)}"


def _way(route: str) -> str:
    return {"blocking": "in the way", "outside": "beside the route"}.get(route, "off every route")


def _criticality(fields: dict[str, Field]) -> int:
    """How pressing it is: what may fall on people first, then what isn't right near people, then what is in the way."""
    unwell, near_people = fields["state"] != "normal", fields["context"] == "safety"
    if near_people and fields["state"] == "unstable" and (fields["location"] == "edge" or fields["route"] == "blocking"):
        return 3
    if near_people and unwell:
        return 2
    return 1 if unwell or (fields["route"] == "blocking" and fields["context"] == "task") else 0


def _setting(spec: DetectorSpec, name: str, default: float) -> float:
    value = spec.settings.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"detector {spec.detector}: settings.{name} must be a number, not {value!r}")
    return float(value)


DETECTORS: dict[str, DetectorFactory] = {"sightings": Sightings, "reports": Reports}
