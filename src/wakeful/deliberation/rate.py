"""How often a reasoner may be called: a sliding minute."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock

from wakeful.contracts.reasoner import ReasonerError

_WINDOW_S = 60.0


class TooOften(ReasonerError):
    """No call is free before the deadline. Nothing was reserved."""


class RateLimit:
    """At most ``per_minute`` calls in any 60 s, whoever makes them.

    Args:
        per_minute: the limit, or None for none.
        clock: seconds that never run back.

    >>> limit = RateLimit(2, clock=lambda: 100.0)
    >>> limit.reserve(9.0), limit.reserve(9.0), limit.reserve(99.0)
    (0.0, 0.0, 60.0)
    """

    def __init__(self, per_minute: int | None, clock: Callable[[], float]) -> None:
        if per_minute is not None and per_minute < 1:
            raise ValueError("a rate limit allows at least one call a minute; to forbid calls, set the budget to 0")
        self._per_minute = per_minute
        self._clock = clock
        self._instants: deque[float] = deque()
        self._lock = Lock()

    def reserve(self, patience_s: float) -> float:
        """Reserve the next free instant.

        Args:
            patience_s: how long the caller could wait for it.

        Returns:
            Seconds to wait before calling.

        Raises:
            TooOften: the wait would be longer than ``patience_s``.
        """
        if self._per_minute is None:
            return 0.0
        with self._lock:
            now_s = self._clock()
            while self._instants and self._instants[0] + _WINDOW_S <= now_s:
                self._instants.popleft()
            free_s = now_s
            if len(self._instants) >= self._per_minute:
                free_s = self._instants[-self._per_minute] + _WINDOW_S
            if free_s - now_s > patience_s:
                raise TooOften(
                    f"the limit of {self._per_minute} reasoner calls a minute is reached: the next is free in "
                    f"{free_s - now_s:.1f} s, later than this answer's deadline; raise WAKEFUL_CALLS_PER_MINUTE"
                )
            self._instants.append(free_s)
            return free_s - now_s
