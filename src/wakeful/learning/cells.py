"""Cells of experience: which validated experiences lie near an event, found without measuring a distance to each of them.

A model version divides what it has learned from into cells, one around each of its exemplars. The experiences near an event
are the newest ones of its own cell.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from collections.abc import Callable, Sequence

from wakeful.facts.events import Event

Place = Callable[[Sequence[Event]], list[int]]


class Cells:
    """The last ``keep`` experiences by cell. What it gives is a function of these and of the model version in use.

    Args:
        place: gives the cells of events by the model version in use; -1 where it has none.
        keep: so many experiences are remembered, and placed anew for each new version.
    """

    def __init__(self, place: Place, keep: int = 1_024) -> None:
        self._place = place
        self._keep = keep
        self._kept: deque[tuple[int, Event]] = deque()
        self._unplaced: list[tuple[int, Event]] = []
        self._cell_of: dict[int, int] = {}
        self._members: dict[int, list[int]] = {}

    def use(self) -> None:
        """Another model version is in use."""
        self._cell_of.clear()
        self._members.clear()
        self._unplaced = list(self._kept)

    def gain(self, experience: int, event: Event, cell: int = -1) -> None:
        """Remember an experience; ``cell`` is its event's by the version in use, -1 where that is not known."""
        self._kept.append((experience, event))
        if cell < 0:
            self._unplaced.append((experience, event))
        else:
            self._enter(experience, cell)
        if len(self._kept) > self._keep:
            self._forget(self._kept.popleft()[0])

    def newest(self, cell: int, limit: int) -> tuple[int, ...]:
        """The newest ``limit`` experiences of a cell, the newest first."""
        if self._unplaced:
            waiting, self._unplaced = self._unplaced[-self._keep :], []
            for (experience, _), own in zip(waiting, self._place([event for _, event in waiting]), strict=True):
                if experience >= self._kept[0][0]:
                    self._enter(experience, own)
        members = self._members.get(cell)
        return tuple(members[: -limit - 1 : -1]) if members else ()

    def _enter(self, experience: int, cell: int) -> None:
        self._cell_of[experience] = cell
        members = self._members.get(cell)
        if members is None:
            self._members[cell] = [experience]
        elif experience > members[-1]:
            members.append(experience)
        else:
            insort(members, experience)

    def _forget(self, experience: int) -> None:
        cell = self._cell_of.pop(experience, None)
        if cell is None:
            return
        members = self._members[cell]
        del members[bisect_left(members, experience)]
        if not members:
            del self._members[cell]
