"""Backpressure: whoever offers more than can be thought about waits until there is room; criticals have room of their own."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

from wakeful.facts.overload import OverloadSettings


class Room:
    """Lets callers in, in the order of their coming, while the backlog is below its limit.

    Args:
        settings: the declared overload policy: its room, and the share of it that is kept for criticals.
        load: how much is offered and not begun.
    """

    def __init__(self, settings: OverloadSettings, load: Callable[[], int]) -> None:
        self._most = settings.refuse_backlog
        self._most_uncritical = max(1, int(settings.refuse_backlog * (1.0 - settings.reserve)))
        self._load = load
        self._waiting: deque[asyncio.Future[None]] = deque()
        self._critical: deque[asyncio.Future[None]] = deque()
        self._entering = 0

    @property
    def waiting(self) -> int:
        """How many callers wait to be let in."""
        return len(self._waiting) + len(self._critical)

    async def enter(self, critical: bool, patience_s: float | None) -> None:
        """Wait for room, or for as long as the caller's patience lasts: what then is offered all the same may be refused.

        Raises:
            Exception: what ``close`` was given.
        """
        queue, most = (self._critical, self._most) if critical else (self._waiting, self._most_uncritical)
        if not queue and self._load() < most:
            return
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        queue.append(turn)
        try:
            async with asyncio.timeout(patience_s):
                await turn
        except TimeoutError:
            return
        finally:
            if turn in queue:
                queue.remove(turn)
            elif not turn.cancelled() and turn.exception() is None:
                self._entering -= 1

    def let_in(self) -> None:
        """Something was begun: so many may come in as there is room for, criticals first. Who was let in and has not offered
        anything yet has his place."""
        load = self._load() + self._entering
        for queue, most in ((self._critical, self._most), (self._waiting, self._most_uncritical)):
            while queue and load < most:
                turn = queue.popleft()
                if not turn.done():
                    turn.set_result(None)
                    self._entering += 1
                    load += 1

    def dismiss(self) -> None:
        """Nothing is taken for now: whoever waits goes on, and hears so from whom he offers it to."""
        for queue in (self._critical, self._waiting):
            while queue:
                turn = queue.popleft()
                if not turn.done():
                    turn.set_result(None)
                    self._entering += 1

    def close(self, error: Exception) -> None:
        """Nobody is let in any more."""
        for queue in (self._critical, self._waiting):
            while queue:
                turn = queue.popleft()
                if not turn.done():
                    turn.set_exception(error)
