"""The registrar: D(o, c) of Eq. 1, made from a domain's data. Observation and memory in; events, evidence and outcomes out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

import msgspec

from wakeful.contracts.detector import Found, Offered, Shown
from wakeful.contracts.domain import Domain, DomainError, Registered
from wakeful.facts.domain import DetectorSpec
from wakeful.facts.events import Condition, Context, Draft, Observation, Phase, event_id
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.registration.channels import named
from wakeful.registration.detectors import BUILT_IN
from wakeful.registration.history import History, Past
from wakeful.registration.identity import evidence_of, outcome_id
from wakeful.registration.latest import Latest
from wakeful.registration.latest import Seen as LatestSeen
from wakeful.registration.memory import EntityMemory, Known, note
from wakeful.registration.open_conditions import OpenConditions, condition_key
from wakeful.registration.plain import LARGEST_INT, clean, field, instant
from wakeful.registration.slots import Slot, slots_of

REPEATED: Final = "condition.repeated"
CLEARED: Final = "condition.cleared"
TOPICS: Final = 4096
ISSUED: Final = 256
"""Positions whose first event's id is remembered, for outcomes that name it."""

_NOTHING: Final = Registered()


class _Route:
    """What a topic's observations go through, and how many there were (of topics that somebody looks at)."""

    __slots__ = ("count", "latest", "slots")

    def __init__(self, slots: tuple[Slot, ...], latest: bool) -> None:
        self.slots = slots
        self.latest = latest
        self.count = 0


class SpecRegistrar:
    """A Registrar for any domain: its detectors by name, its outcome and evidence sources, a bounded memory.

    Args:
        domain: data, and detectors of its own.
        digest: of the source's content, or a live source's incarnation; part of every id.

    Raises:
        DomainError: the domain names a detector, a setting or a placeholder that doesn't exist.
    """

    def __init__(self, domain: Domain, digest: str) -> None:
        spec = domain.spec
        self._spec = spec
        self._digest = digest
        self._slots = slots_of(spec, {**BUILT_IN, **domain.detectors()})
        self._hears_all = tuple(slot for slot in self._slots if slot.hears_all)
        self._routes: dict[str, _Route | None] = {}
        self._counts: dict[str, int] = {}
        self._latest = Latest(spec.fields)
        self._memory = EntityMemory(spec.fields)
        self._history = History(spec)
        self._conditions = OpenConditions()
        self._issued: dict[int, str] = {}
        self._written: dict[str, bytes] = {}

    def observe(self, observation: Observation) -> Registered:
        """Register one observation.

        Returns:
            Its events in the order of the domain's detectors, evidence, and outcomes. What it shows of outcomes is part of the
            history of its own events: it has been seen by then.
        """
        topic = observation.topic
        try:
            route = self._routes[topic]
        except KeyError:
            route = self._route(topic)
        if route is None:
            return _NOTHING
        if not -LARGEST_INT < observation.at_ns < LARGEST_INT:
            observation = msgspec.structs.replace(observation, at_ns=instant(observation.at_ns))
        route.count += 1
        if route.latest:
            self._latest.observe(observation)
        seen: list[tuple[Slot, Found | Shown | Offered]] = []
        for slot in route.slots:
            slot.dirty = True
            try:
                seen.extend([(slot, item) for item in slot.detector.observe(observation)])
            except Exception as error:
                error.add_note(f"in detector {slot.key} at position {observation.position} of {observation.source}")
                raise
        return self._registered(seen, observation, route) if seen else _NOTHING

    def changed(self) -> dict[str, bytes]:
        """The parts of the state that changed since the last call: one for each detector, shards of the memory, and the rest."""
        parts = self._memory.changed()
        for slot in self._slots:
            if slot.dirty:
                parts[slot.key] = slot.detector.state()
                slot.dirty = False
        counts = {clean(topic): route.count for topic, route in self._routes.items() if route is not None}
        parts["counts"] = msgspec.msgpack.encode({**self._counts, **counts})
        parts["latest"] = msgspec.msgpack.encode(self._latest.seen)
        parts["history"] = msgspec.msgpack.encode(self._history.past)
        parts["conditions"] = self._conditions.state()
        parts["issued"] = msgspec.msgpack.encode(self._issued)
        parts = {name: part for name, part in parts.items() if self._written.get(name) != part}
        self._written.update(parts)
        return parts

    def restore(self, parts: Mapping[str, bytes]) -> None:
        """Take up the state that ``changed`` gave out, all parts together.

        Raises:
            DomainError: a part was not written by this domain's detectors; the message says which.
        """
        self._routes.clear()
        self._written = dict(parts)
        name = "memory"
        try:
            self._memory.restore(parts)
            for slot in self._slots:
                name = slot.key
                if name in parts:
                    slot.detector.restore(parts[name])
                slot.dirty = False
            name = "history and conditions"
            self._counts = msgspec.msgpack.decode(parts.get("counts", b"\x80"), type=dict[str, int])
            self._latest.seen = msgspec.msgpack.decode(parts.get("latest", b"\x80"), type=LatestSeen)
            self._history.past = msgspec.msgpack.decode(parts.get("history", b"\x80"), type=Past)
            self._conditions.restore(parts.get("conditions", b"\x80"))
            self._issued = msgspec.msgpack.decode(parts.get("issued", b"\x80"), type=dict[int, str])
        except (msgspec.DecodeError, msgspec.ValidationError) as error:
            raise DomainError(
                f"domain {self._spec.name}: the recorded state of {name} is not what this version of it writes ({error}); "
                "go on with the version that wrote it, or begin a new journal"
            ) from error

    def _route(self, topic: str) -> _Route | None:
        if len(self._routes) >= TOPICS:
            self._counts = {clean(name): route.count for name, route in self._routes.items() if route is not None}
            self._routes.clear()
        slots = tuple(slot for slot in self._slots if slot.hears_all or slot.channels.concern(topic))
        latest = self._latest.concerns(topic)
        route = _Route(slots, latest) if slots or latest else None
        if route is not None:
            route.count = self._counts.get(clean(topic), 0)
        self._routes[topic] = route
        return route

    def _registered(
        self, seen: Iterable[tuple[Slot, Found | Shown | Offered]], observation: Observation, route: _Route
    ) -> Registered:
        robot = observation.robot or self._spec.robot
        outcomes = [self._outcome(item, observation) for _, item in seen if isinstance(item, Shown)]
        events: list[Draft] = []
        evidence: list[Evidence] = []
        for slot, item in seen:
            if isinstance(item, Found):
                made = self._draft(slot.spec, item, observation, route, robot, len(events), len(evidence))
                if isinstance(made, Draft):
                    events.append(made)
                elif made is not None:
                    evidence.append(made)
            elif isinstance(item, Offered):
                evidence.append(
                    evidence_of(self._digest, observation, clean(item.topic), clean(item.key), item.value, len(evidence))
                )
        if events:
            first = events[0]
            self._issued[first.position] = event_id(robot, self._digest, first.position, first.kind, first.ordinal)
            if len(self._issued) > ISSUED:
                del self._issued[next(iter(self._issued))]
        return Registered(tuple(events), tuple(evidence), tuple(outcomes))

    def _outcome(self, shown: Shown, observation: Observation) -> Outcome:
        self._history.shown(shown.label, observation.at_ns)
        entity = clean(shown.entity)
        return Outcome(
            id=outcome_id(self._digest, observation.position, shown.label, entity),
            topic=self._spec.outcome.topic,
            entity=entity,
            label=shown.label,
            at_ns=observation.at_ns,
            event="" if shown.event_position is None else self._issued.get(shown.event_position, ""),
            treatment=shown.treatment,
            acted_on=shown.acted_on,
            source=observation.source,
        )

    def _draft(
        self, spec: DetectorSpec, found: Found, observation: Observation, route: _Route, robot: str, ordinal: int, offered: int
    ) -> Draft | Evidence | None:
        kind = found.kind or spec.kind
        entity = clean(found.entity or named(spec.entity, observation.topic, observation.topic, robot))
        fields = {clean(name): field(value) for name, value in found.fields.items()}
        zone, at_ns = clean(found.zone), observation.at_ns
        relation, known = self._memory.know(entity, zone, fields)
        condition = None
        if found.phase is not None:
            key = condition_key(found if found.type else msgspec.structs.replace(found, type=kind), robot, observation.source)
            phase = self._conditions.take(key, found.phase, at_ns)
            if phase is None:
                return None
            if phase in (Phase.REPEATED, Phase.CLEARED):
                topic = REPEATED if phase is Phase.REPEATED else CLEARED
                return evidence_of(self._digest, observation, topic, key, fields, offered)
            condition = Condition(key=key, phase=phase)
        topic = clean(observation.topic)
        stands_for = route.count - known.observations.get(topic, 0)
        criticality = spec.criticality if found.criticality is None else found.criticality
        draft = Draft(
            kind=kind,
            entity=entity,
            source=observation.source,
            position=observation.position,
            at_ns=at_ns,
            ordinal=ordinal,
            robot=robot,
            relation=relation,
            fields=fields,
            context=self._context(found, known, kind, entity, at_ns),
            condition=condition,
            criticality=min(max(criticality, 0), 3),  # type: ignore[arg-type]
            deadline_s=spec.deadline_s if found.deadline_s is None else found.deadline_s,
            says=clean(found.says, 400),
            observations=max(stands_for, found.observations, 1),
            clock=clean(observation.clock),
            uncertainty_ns=min(max(observation.uncertainty_ns, 0), LARGEST_INT),
            truth_treatment=found.truth_treatment,
        )
        note(known, kind, topic, route.count, at_ns)
        self._history.registered(at_ns)
        return draft

    def _context(self, found: Found, known: Known, kind: str, entity: str, at_ns: int) -> Context:
        fields = {**self._history.of(known, kind, at_ns), **self._latest.fields(entity, at_ns)}
        return Context(task=clean(found.task), zone=clean(found.zone) or known.zone, safety=found.safety, fields=fields)
