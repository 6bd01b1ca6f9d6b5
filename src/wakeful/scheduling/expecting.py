"""Which open processes wait for which evidence, which are about which condition, and which wait for nothing but evidence."""

from __future__ import annotations

from itertools import islice

from wakeful.scheduling.process import Process


class Expecting:
    """Process ids by evidence and by condition, in the order in which they came."""

    def __init__(self) -> None:
        self._by_condition: dict[str, list[int]] = {}
        self._by_evidence: dict[str, list[int]] = {}
        self._waiters: dict[int, None] = {}

    def about(self, condition: str) -> list[int]:
        """The root processes about that condition."""
        return self._by_condition.get(condition, [])

    def of(self, topic_key: str) -> list[int]:
        """The processes that wait for that evidence."""
        return self._by_evidence.get(topic_key, [])

    @property
    def waiters(self) -> int:
        """How many nobody but their evidence, their limit or an operator will ask for: they can be parked."""
        return len(self._waiters)

    def oldest(self, count: int) -> list[int]:
        """The ``count`` of those that have waited longest."""
        return list(islice(self._waiters, count))

    def came(self, process: Process) -> None:
        """It is open from now on."""
        if process.event.condition is not None and not process.parent:
            self._by_condition.setdefault(process.event.condition.key, []).append(process.id)

    def gone(self, process: Process) -> None:
        """It is open no longer."""
        if process.event.condition is not None and not process.parent:
            _drop(self._by_condition, process.event.condition.key, process.id)

    def expects(self, process: Process, topic_key: str) -> None:
        """It waits for that evidence."""
        self._by_evidence.setdefault(topic_key, []).append(process.id)
        if not (process.parent or process.held_by or process.event.condition):
            self._waiters[process.id] = None

    def expects_no_more(self, process: int, topic_key: str) -> None:
        """It waits for it no longer."""
        _drop(self._by_evidence, topic_key, process)
        self._waiters.pop(process, None)

    def held(self, process: int) -> None:
        """An operator holds it: it stays at hand."""
        self._waiters.pop(process, None)

    def released(self, process: Process) -> None:
        """Nobody holds it any longer."""
        waits = process.asked and process.id in self.of(process.asked[-1].key)
        if waits and not (process.parent or process.event.condition):
            self._waiters[process.id] = None


def _drop(index: dict[str, list[int]], key: str, process: int) -> None:
    """Take a process out of an index, and the entry with it once nobody is left."""
    members = index.get(key)
    if members is not None and process in members:
        members.remove(process)
        if not members:
            del index[key]
