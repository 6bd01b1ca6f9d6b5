"""Which events were admitted, up to a declared horizon: one that comes again within it is a duplicate."""

from __future__ import annotations


class Seen:
    """Ids of admitted events: at most the newest ``keep`` of them, at least half as many. About 120 bytes each.

    They stand in two generations: when the younger has half of them, the older is given up.
    """

    def __init__(self, keep: int) -> None:
        self._half = max(1, keep // 2)
        self._young: set[str] = set()
        self._old: set[str] = set()

    def add(self, event: str) -> None:
        """An event was admitted."""
        self._young.add(event)
        if len(self._young) >= self._half:
            self._old, self._young = self._young, set()

    def __contains__(self, event: str) -> bool:
        return event in self._young or event in self._old
