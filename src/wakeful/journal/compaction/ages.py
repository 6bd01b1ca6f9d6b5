"""How old what is: the rows that were not compacted yet, in stretches of about a thousand events, oldest first."""

from __future__ import annotations

from collections import deque

import msgspec

from wakeful.journal.retention import Retention

#: So many events make a stretch; a boundary lies between two of them.
_EVENTS = 1_024

_NS_PER_DAY = 86_400_000_000_000


class _Stretch(msgspec.Struct):
    last: int = 0
    at_ns: int = 0
    admitted: int = 0


class Ages:
    """Says up to where a journal may be given up."""

    def __init__(self) -> None:
        self._stretches: deque[_Stretch] = deque()
        self._growing = _Stretch()
        self._admitted = 0
        self._newest_ns = 0

    def add(self, last: int, at_ns: int, admitted: int) -> bool:
        """A row was committed; returns whether it completed a stretch."""
        growing = self._growing
        growing.last, growing.at_ns = last, at_ns
        growing.admitted += admitted
        self._admitted += admitted
        self._newest_ns = at_ns
        if growing.admitted < _EVENTS:
            return False
        self._stretches.append(growing)
        self._growing = _Stretch()
        return True

    def boundary(self, retention: Retention, used_bytes: int, least_events: int = 0) -> int:
        """The last position that may be given up; 0 where that is nothing, or too little to be worth the while.

        Args:
            retention: what is kept.
            used_bytes: what the file holds.
            least_events: how many events make it worth the while; the twentieth part of all where 0.
        """
        worth = least_events or max(_EVENTS, self._admitted // 20)
        keep = self._admitted
        if retention.events:
            keep = min(keep, retention.events)
        limit_bytes = retention.megabytes * 1_000_000
        if limit_bytes and used_bytes > limit_bytes:
            keep = min(keep, self._admitted * limit_bytes // used_bytes - worth)
        keep = max(keep, retention.least)
        oldest_ns = self._newest_ns - int(retention.days * _NS_PER_DAY) if retention.days else None
        place, given_up = 0, 0
        for stretch in self._stretches:
            left = self._admitted - given_up - stretch.admitted
            aged = oldest_ns is not None and stretch.at_ns < oldest_ns and left >= retention.least
            if not aged and left < keep:
                break
            place, given_up = stretch.last, given_up + stretch.admitted
        return place if given_up >= worth else 0

    def half_full(self, retention: Retention, used_bytes: int) -> bool:
        """Whether half of what may be kept is there: time to find out what is owed, before there is something to give up."""
        events, limit_bytes = retention.events, retention.megabytes * 1_000_000
        return bool(events and 2 * self._admitted > events) or bool(limit_bytes and 2 * used_bytes > limit_bytes)

    def given_up(self, boundary: int) -> None:
        """What lies up to there was compacted."""
        while self._stretches and self._stretches[0].last <= boundary:
            self._admitted -= self._stretches.popleft().admitted
