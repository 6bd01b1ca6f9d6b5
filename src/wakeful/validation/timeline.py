"""An index by source time: what lies in a window, found without looking at the rest."""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections.abc import Iterator
from typing import Generic, TypeVar

K = TypeVar("K", int, str)


class Timeline(Generic[K]):
    """Keys with an instant each, per bucket and over all buckets, ordered by (instant, key).

    >>> line = Timeline[str]()
    >>> line.add("door", 5, "a"); line.add("door", 9, "b"); line.add("lift", 7, "c")
    >>> list(line.between("door", 5, 9)), list(line.between(None, 4, 9))
    (['b'], ['a', 'c', 'b'])
    """

    def __init__(self) -> None:
        self._all: list[tuple[int, K]] = []
        self._buckets: dict[str, list[tuple[int, K]]] = {}

    def add(self, bucket: str, at_ns: int, key: K) -> None:
        """Enter ``key`` at ``at_ns``. The same entry twice must not be added."""
        insort(self._all, (at_ns, key))
        insort(self._buckets.setdefault(bucket, []), (at_ns, key))

    def remove(self, bucket: str, at_ns: int, key: K) -> None:
        """Take out what ``add`` entered with the same arguments."""
        _take_out(self._all, (at_ns, key))
        rest = self._buckets[bucket]
        _take_out(rest, (at_ns, key))
        if not rest:
            del self._buckets[bucket]

    def between(self, bucket: str | None, after_ns: int, until_ns: int) -> Iterator[K]:
        """Keys with after_ns < instant <= until_ns, earliest first, of one bucket or (None) of all."""
        entries = self._all if bucket is None else self._buckets.get(bucket, [])
        first = bisect_right(entries, after_ns, key=_instant)
        last = bisect_right(entries, until_ns, key=_instant)
        return (key for _, key in entries[first:last])


def _instant(entry: tuple[int, K]) -> int:
    return entry[0]


def _take_out(entries: list[tuple[int, K]], entry: tuple[int, K]) -> None:
    at = bisect_left(entries, entry)
    if at == len(entries) or entries[at] != entry:
        raise KeyError(entry)
    del entries[at]
