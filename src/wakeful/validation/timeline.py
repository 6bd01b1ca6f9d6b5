"""An index by source time: what lies in a window, found without looking at the rest."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
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
        self._gone: set[tuple[int, K]] = set()
        self._buckets: dict[str, list[tuple[int, K]]] = {}

    def __contains__(self, bucket: str) -> bool:
        return bucket in self._buckets

    def in_bucket(self, bucket: str) -> Sequence[tuple[int, K]]:
        """All entries of one bucket, earliest first."""
        return self._buckets.get(bucket, ())

    def add(self, bucket: str, at_ns: int, key: K) -> None:
        """Enter ``key`` at ``at_ns``. The same entry twice must not be added."""
        entry = (at_ns, key)
        _enter(self._all, entry)
        entries = self._buckets.get(bucket)
        if entries is None:
            self._buckets[bucket] = [entry]
        else:
            _enter(entries, entry)
        if self._gone:
            self._gone.discard(entry)

    def remove(self, bucket: str, at_ns: int, key: K) -> None:
        """Take out what ``add`` entered with the same arguments."""
        entry = (at_ns, key)
        rest = self._buckets[bucket]
        _take_out(rest, entry)
        if not rest:
            del self._buckets[bucket]
        # Of all entries it is taken out later, with many others: a long list is not moved for each of them.
        self._gone.add(entry)
        if 2 * len(self._gone) > len(self._all):
            gone = self._gone
            self._all = [each for each in self._all if each not in gone]
            self._gone = set()

    def between(self, bucket: str | None, after_ns: int, until_ns: int) -> list[K]:
        """Keys with after_ns < instant <= until_ns, earliest first, of one bucket or (None) of all."""
        entries = self._all if bucket is None else self._buckets.get(bucket)
        if not entries:
            return []
        # (t,) stands before every (t, key).
        found = entries[bisect_left(entries, (after_ns + 1,)) : bisect_left(entries, (until_ns + 1,))]
        if bucket is None and self._gone:
            return [key for at_ns, key in found if (at_ns, key) not in self._gone]
        return [key for _, key in found]


def _enter(entries: list[tuple[int, K]], entry: tuple[int, K]) -> None:
    """Nearly everything comes in order."""
    if not entries or entry > entries[-1]:
        entries.append(entry)
    else:
        insort(entries, entry)


def _take_out(entries: list[tuple[int, K]], entry: tuple[int, K]) -> None:
    at = bisect_left(entries, entry)
    if at == len(entries) or entries[at] != entry:
        raise KeyError(entry)
    del entries[at]
