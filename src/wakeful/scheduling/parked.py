"""Who is parked: long waiters by id, by what they wait for, and by when their wait passes. 41 bytes each.

Python's own objects would take four times as much, and the garbage collector would walk over them. New entries stand in a
small dictionary; from ``FRESH`` on they become a run of sorted columns, and ``RUNS`` runs become one larger run.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numpy.typing import NDArray

from wakeful.facts.time import LARGEST_NS

Column = NDArray[np.int64]

#: So many new entries are sorted into a run.
FRESH = 4_096

#: So many runs of that size are made into one: larger ones would take too long to sort between two feeds.
RUNS = 8


class _Run:
    """Columns in the order of process ids: (n,) each; ``by_key`` and ``by_limit`` are the places in another order."""

    __slots__ = ("by_key", "by_limit", "first", "gone", "highest", "in_time", "keys", "left", "limits", "lowest", "processes")

    def __init__(self, processes: Column, keys: Column, limits: Column) -> None:
        order = np.argsort(processes, kind="stable")
        self.processes = processes[order]
        hashed = keys[order]
        self.limits = limits[order]
        self.by_key = np.argsort(hashed, kind="stable").astype(np.uint32)
        self.keys = hashed[self.by_key]
        self.by_limit = np.argsort(self.limits, kind="stable").astype(np.uint32)
        self.in_time = self.limits[self.by_limit]
        self.lowest, self.highest = int(self.processes[0]), int(self.processes[-1])
        self.gone = np.zeros(len(processes), np.bool_)
        self.first = 0
        self.left = len(processes)

    def columns(self) -> tuple[Column, Column, Column]:
        """Processes, hashed keys and limits of those that are still parked."""
        keys = np.empty_like(self.keys)
        keys[self.by_key] = self.keys
        return self.processes[~self.gone], keys[~self.gone], self.limits[~self.gone]

    def place(self, process: int) -> int:
        """Where it stands; -1 where it does not, or no longer."""
        if not self.lowest <= process <= self.highest:
            return -1
        place = int(self.processes.searchsorted(process))
        return place if self.processes[place] == process and not self.gone[place] else -1

    def of_key(self, key: int) -> list[int]:
        """The processes whose key has that hash."""
        found: list[int] = []
        at = int(self.keys.searchsorted(key))
        while at < len(self.keys) and self.keys[at] == key:
            place = self.by_key[at]
            if not self.gone[place]:
                found.append(int(self.processes[place]))
            at += 1
        return found

    def soonest_ns(self) -> int:
        """When the first limit passes."""
        while self.first < len(self.by_limit) and self.gone[self.by_limit[self.first]]:
            self.first += 1
        return int(self.in_time[self.first]) if self.first < len(self.in_time) else LARGEST_NS

    def until(self, at_ns: int) -> list[int]:
        """The processes whose limits pass by then."""
        until = int(self.in_time.searchsorted(at_ns, "right"))
        return [int(self.processes[each]) for each in self.by_limit[self.first : until] if not self.gone[each]]

    def drop(self, place: int) -> None:
        """It is parked no longer."""
        self.gone[place] = True
        self.left -= 1


class Parked:
    """Parked processes. Keys are held by their hash: who is found by one may wait for another key of the same hash."""

    def __init__(self) -> None:
        self._fresh: dict[int, tuple[int, int]] = {}
        self._fresh_by_key: dict[int, list[int]] = {}
        self._fresh_limits: list[tuple[int, int]] = []
        self._runs: list[_Run] = []
        self._soonest_ns = LARGEST_NS
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def __contains__(self, process: int) -> bool:
        return process in self._fresh or any(run.place(process) >= 0 for run in self._runs)

    @property
    def soonest_ns(self) -> int:
        """When the next limit of a parked process passes; LARGEST_NS where none does."""
        return self._soonest_ns

    def park(self, process: int, key: str, limit_ns: int | None) -> None:
        """Take a process in that waits for ``key`` until ``limit_ns``."""
        hashed, limit = hash(key), LARGEST_NS if limit_ns is None else limit_ns
        self._fresh[process] = (hashed, limit)
        self._fresh_by_key.setdefault(hashed, []).append(process)
        heappush(self._fresh_limits, (limit, process))
        self._soonest_ns = min(self._soonest_ns, limit)
        self._count += 1
        if len(self._fresh) >= FRESH:
            self._sort()

    def leave(self, process: int) -> None:
        """It is parked no longer. Raises KeyError where it was not."""
        found = self._fresh.pop(process, None)
        if found is not None:
            hashed, limit = found
            sharing = self._fresh_by_key[hashed]
            sharing.remove(process)
            if not sharing:
                del self._fresh_by_key[hashed]
        else:
            run, place = self._stands(process)
            limit = int(run.limits[place])
            run.drop(place)
            if not run.left:
                self._runs.remove(run)
        self._count -= 1
        if limit <= self._soonest_ns:
            self._soonest_ns = min([self._fresh_soonest_ns(), *(each.soonest_ns() for each in self._runs)])

    def waiting_for(self, key: str) -> list[int]:
        """Who may wait for that key, by id."""
        if not self._count:
            return []
        hashed = hash(key)
        found = list(self._fresh_by_key.get(hashed, ()))
        for run in self._runs:
            found += run.of_key(hashed)
        return sorted(found)

    def until(self, at_ns: int) -> list[int]:
        """Whose limits pass by then, by id."""
        if at_ns < self._soonest_ns:
            return []
        found: list[int] = []
        if self._fresh_soonest_ns() <= at_ns:
            found = [process for process, (_, limit) in self._fresh.items() if limit <= at_ns]
        for run in self._runs:
            found += run.until(at_ns)
        return sorted(found)

    def _fresh_soonest_ns(self) -> int:
        limits = self._fresh_limits
        while limits and self._fresh.get(limits[0][1], (0, -1))[1] != limits[0][0]:
            heappop(limits)
        return limits[0][0] if limits else LARGEST_NS

    def _stands(self, process: int) -> tuple[_Run, int]:
        for run in self._runs:
            place = run.place(process)
            if place >= 0:
                return run, place
        raise KeyError(process)

    def _sort(self) -> None:
        processes = np.fromiter(self._fresh, np.int64, len(self._fresh))
        rest = np.array(list(self._fresh.values()), np.int64)
        self._runs.append(_Run(processes, rest[:, 0], rest[:, 1]))
        self._fresh, self._fresh_by_key, self._fresh_limits = {}, {}, []
        small = [run for run in self._runs if run.left <= FRESH]
        if len(small) >= RUNS:
            columns = (np.concatenate(each) for each in zip(*(run.columns() for run in small), strict=True))
            self._runs = [run for run in self._runs if run.left > FRESH]
            self._runs.append(_Run(*columns))
