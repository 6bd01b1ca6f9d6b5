"""Identities: an event's id is the digest of where it came from, computed again from what is recorded."""

from __future__ import annotations

from wakeful.facts.events import event_id
from wakeful.facts.lines import Admitted, Line, Opened
from wakeful.journal.checks.check import Check


class Identities(Check):
    """Every admitted event came from a source that was opened, and its id is the digest of robot, source, position and kind."""

    name = "identities"
    says = "every event's id is computed again from its robot, its source's digest, its position, kind and ordinal"

    def __init__(self) -> None:
        super().__init__()
        self._digests: dict[str, str] = {}

    def see(self, line: Line) -> None:
        """Compute each id again."""
        record = line.record
        if isinstance(record, Opened):
            self._digests[record.source] = record.digest
        elif isinstance(record, Admitted):
            self.checked += 1
            event = record.event
            digest = self._digests.get(event.source)
            if digest is None:
                self.offend(line, f"event {event.id} comes from {event.source}, which was never opened")
            elif event.id != (due := event_id(event.robot, digest, event.position, event.kind, event.ordinal)):
                self.offend(line, f"event {event.id} is not what its robot, source, position and kind give: {due}")
