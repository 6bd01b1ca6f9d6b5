"""Outcomes that were witnessed, kept for the results that are concluded after them."""

from __future__ import annotations

from collections import deque

from wakeful.facts.evidence import Outcome
from wakeful.validation.ledger import ANY, Entry, concerns
from wakeful.validation.timeline import Timeline


class Witnesses:
    """At most ``keep`` outcomes, by id, by event and by (entity, source time); the first of an id counts.

    ``forgotten_ns`` is when the latest of the forgotten ones was received, in kernel time; None while all are remembered.
    """

    def __init__(self, scope: str, keep: int) -> None:
        self._by_robot = scope == "robot"
        self._keep = keep
        self._outcomes: dict[str, Outcome] = {}
        self._received: dict[str, tuple[int, int]] = {}
        self._order: deque[str] = deque()
        self._count = 0
        self._timeline: Timeline[str] = Timeline()
        self._of_event: dict[str, list[str]] = {}
        self.forgotten_ns: int | None = None

    def get(self, outcome: str) -> Outcome | None:
        """The outcome of that id; None where it is unknown or forgotten."""
        return self._outcomes.get(outcome)

    def add(self, outcome: Outcome, received_ns: int) -> bool:
        """Remember an outcome. False, and nothing changes, where its id is known."""
        if outcome.id in self._outcomes:
            return False
        self._count += 1
        self._outcomes[outcome.id] = outcome
        self._received[outcome.id] = (received_ns, self._count)
        self._order.append(outcome.id)
        if outcome.event:
            self._of_event.setdefault(outcome.event, []).append(outcome.id)
        else:
            self._timeline.add(outcome.entity, outcome.at_ns, outcome.id)
        while len(self._order) > self._keep:
            self._forget(self._order.popleft())
        return True

    def concerning(self, entry: Entry) -> list[Outcome]:
        """What was witnessed so far that may judge the entry, the first in source time first, then as received."""
        if not self._by_robot and entry.entity != ANY and not self._may_concern(entry):
            return []
        ids = set(self._of_event.get(entry.event, ()))
        for bucket in {None} if self._by_robot or entry.entity == ANY else {entry.entity, ANY}:
            ids.update(self._timeline.between(bucket, entry.since_ns, entry.until_ns))
        found = [outcome for id_ in ids if concerns(outcome := self._outcomes[id_], entry, self._by_robot)]
        return sorted(found, key=lambda outcome: (outcome.at_ns, self._received[outcome.id]))

    def _may_concern(self, entry: Entry) -> bool:
        return entry.entity in self._timeline or entry.event in self._of_event or ANY in self._timeline

    def _forget(self, id_: str) -> None:
        outcome = self._outcomes.pop(id_)
        received_ns, _ = self._received.pop(id_)
        self.forgotten_ns = received_ns if self.forgotten_ns is None else max(self.forgotten_ns, received_ns)
        if not outcome.event:
            self._timeline.remove(outcome.entity, outcome.at_ns, id_)
            return
        rest = self._of_event[outcome.event]
        rest.remove(id_)
        if not rest:
            del self._of_event[outcome.event]
