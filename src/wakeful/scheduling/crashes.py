"""How often the treatment of an event has ended the process that ran the mind: the fold of what recovery recorded."""

from __future__ import annotations

from wakeful.facts.crashes import CRASHED, MARKED
from wakeful.facts.lines import Noted


class Crashes:
    """Counted by event, since a crash may take the record of its process with it. One run that is told twice counts once."""

    def __init__(self) -> None:
        self._runs: dict[str, set[str]] = {}

    def of(self, event: str) -> int:
        """How many runs ended while that event was being treated."""
        return len(self._runs.get(event[:MARKED], ())) if self._runs else 0

    def apply(self, record: Noted) -> None:
        """Count what recovery found."""
        if record.what == CRASHED:
            self._runs.setdefault(record.event[:MARKED], set()).add(record.detail)

    def forget(self, event: str) -> None:
        """It is thought about afresh (reopened): what happened before does not count."""
        self._runs.pop(event[:MARKED], None)
