"""How long to wait before trying again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime
from email.utils import parsedate_to_datetime
from random import Random


class Backoff:
    """Exponential backoff with jitter: the n-th wait is a random 50 to 100 % of ``first_s`` × 2ⁿ, at most ``limit_s``.

    Args:
        first_s: the wait after the first failure, before jitter.
        limit_s: the longest wait, before jitter.
        seed: makes the jitter repeatable.

    >>> Backoff(1.0, 8.0, seed=0).wait_s(10) <= 8.0
    True
    """

    def __init__(self, first_s: float, limit_s: float, seed: int) -> None:
        self._first_s = first_s
        self._limit_s = limit_s
        self._random = Random(seed)

    def wait_s(self, failures: int, retry_after_s: float = 0.0) -> float:
        """Seconds to wait after so many failures (0: after the first), never less than the endpoint asked for."""
        full_s = self._limit_s if failures > 30 else min(self._limit_s, self._first_s * 2**failures)
        return max(retry_after_s, full_s * (0.5 + 0.5 * self._random.random()))


def retry_after_s(headers: Mapping[str, str]) -> float:
    """What a response's Retry-After asks for, in seconds; 0 where it asks for nothing that can be understood.

    A date is read against the response's own Date header, so that this machine's clock does not matter.

    >>> retry_after_s({"retry-after": "7"})
    7.0
    """
    asked = headers.get("retry-after", "").strip()
    try:
        seconds = float(asked)
    except ValueError:
        until, now = _instant(asked), _instant(headers.get("date", ""))
        seconds = (until - now).total_seconds() if until and now else 0.0
    return seconds if math.isfinite(seconds) and seconds > 0 else 0.0


def _instant(text: str) -> datetime | None:
    try:
        instant = parsedate_to_datetime(text)
    except ValueError:
        return None
    return instant if instant.tzinfo else None
