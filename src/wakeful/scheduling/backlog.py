"""The backlog: processes that have not begun to be treated, in the order of their coming, and how many are whose."""

from __future__ import annotations

from collections import OrderedDict


class Backlog:
    """A fold over creations and first dispatches; those that an operator holds are not in it. O(1) a change."""

    def __init__(self) -> None:
        self._since: OrderedDict[int, tuple[int, str]] = OrderedDict()
        self._by_source: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._since)

    def came(self, process: int, source: str, now_ns: int) -> None:
        """A process is there and has not begun."""
        if process not in self._since:
            self._since[process] = (now_ns, source)
            self._by_source[source] = self._by_source.get(source, 0) + 1

    def left(self, process: int) -> None:
        """It began, ended, or is held. Nothing where it was not in the backlog."""
        found = self._since.pop(process, None)
        if found is not None:
            left = self._by_source[found[1]] - 1
            if left:
                self._by_source[found[1]] = left
            else:
                del self._by_source[found[1]]

    def of(self, source: str) -> int:
        """How many are of that source."""
        return self._by_source.get(source, 0)

    @property
    def oldest_ns(self) -> int | None:
        """When the one came that has waited longest; None where nobody waits."""
        return next(iter(self._since.values()))[0] if self._since else None
