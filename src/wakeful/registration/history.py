"""Recent history at the time of an event, as fields of its context that a learner can use."""

from __future__ import annotations

from typing import Final

import msgspec

from wakeful.facts.domain import DomainSpec
from wakeful.facts.values import Field
from wakeful.registration.memory import Known
from wakeful.registration.plain import elapsed_s

RECENT_S: Final = 600.0
"""How far back "recent" goes."""
KEPT: Final = 256
"""Instants that are kept of events, and of each outcome label."""


class Past(msgspec.Struct):
    """When events were registered, and outcomes shown, of late. ``outcomes``: by label."""

    events_ns: list[int] = []
    outcomes_ns: dict[str, list[int]] = {}


class History:
    """What an event's context says of the past of its robot and of its entity.

    Fields, all counted before the event itself (one whose past is empty is left out):
    ``since_event_s`` and ``recent_events`` of the robot; ``since_entity_s`` and ``recent_entity`` of the entity;
    ``since_same_s`` of the same kind of event of the entity; for each outcome label ``since_<label>_s`` and ``recent_<label>``.
    "recent" is the last RECENT_S seconds.

    Args:
        spec: a domain that names any of these, among its fields or in a ``when``, gets only those it names; else it gets all.
    """

    def __init__(self, spec: DomainSpec) -> None:
        self._labels = spec.outcome.labels[1:]
        given = set(history_fields(spec.outcome.labels))
        named = set(spec.fields).union(*(line.when for line in spec.guideline), *(line.when for line in spec.hazard))
        self._wanted = given & named or given
        self.past = Past()

    def of(self, known: Known, kind: str, now_ns: int) -> dict[str, Field]:
        """The fields for an event of this kind, of the entity that ``known`` remembers."""
        same = known.kinds.get(kind)
        pasts: list[tuple[str, str, list[int]]] = [
            ("since_event_s", "recent_events", self.past.events_ns),
            ("since_entity_s", "recent_entity", known.recent_ns),
            ("since_same_s", "", [] if same is None else [same]),
        ]
        pasts += [(f"since_{label}_s", f"recent_{label}", self.past.outcomes_ns.get(label, [])) for label in self._labels]
        fields: dict[str, Field] = {}
        for since, recent, instants_ns in pasts:
            if since in self._wanted and instants_ns and (gone_s := elapsed_s(now_ns, instants_ns[-1])) != float("inf"):
                fields[since] = round(gone_s, 3)
            if recent in self._wanted:
                fields[recent] = _count(instants_ns, now_ns)
        return fields

    def registered(self, now_ns: int) -> None:
        """An event was registered."""
        self.past.events_ns = [*self.past.events_ns[-(KEPT - 1) :], now_ns]

    def shown(self, label: str, now_ns: int) -> None:
        """An outcome was shown."""
        if label in self._labels:
            self.past.outcomes_ns[label] = [*self.past.outcomes_ns.get(label, [])[-(KEPT - 1) :], now_ns]


def history_fields(labels: tuple[str, ...]) -> tuple[str, ...]:
    """The names of all fields that `History` may give for these outcome labels."""
    own = tuple(name for label in labels[1:] for name in (f"since_{label}_s", f"recent_{label}"))
    return ("since_event_s", "recent_events", "since_entity_s", "recent_entity", "since_same_s", *own)


def _count(instants_ns: list[int], now_ns: int) -> int:
    count = 0
    for at_ns in reversed(instants_ns):
        if elapsed_s(now_ns, at_ns) > RECENT_S:
            break
        count += 1
    return count
