"""Instants as sources write them: ISO 8601, or a number of seconds, milli-, micro- or nanoseconds since 1970."""

from __future__ import annotations

import datetime
import math
from typing import Final

from wakeful.facts.time import NS_PER_S

LATEST_NS: Final = 2**62
"""Instants are kept within this (the year 2116), so that sums of them stay within 64 bits."""
_EPOCH: Final = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
#: A number below the bound counts in this many nanoseconds: 1e11 s lies in the year 5138, 1e11 ms in 1973.
_UNITS: Final = ((1e11, NS_PER_S), (1e14, 1_000_000), (1e17, 1_000), (math.inf, 1))


def instant_ns(value: object) -> int | None:
    """The instant that ``value`` says, in nanoseconds since 1970; None where it says none.

    Text without a zone is UTC; quotes around it are taken off. Numbers are read by their size as s, ms, µs or ns.

    >>> instant_ns("1970-01-01T00:00:01.5Z"), instant_ns('"1970-01-01 00:00:02"'), instant_ns(3), instant_ns("soon")
    (1500000000, 2000000000, 3000000000, None)
    >>> instant_ns(1_700_000_000_123)
    1700000000123000000
    """
    if isinstance(value, datetime.datetime):
        return _bounded(_since_epoch(value))
    if isinstance(value, datetime.date):
        return _bounded(_since_epoch(datetime.datetime(value.year, value.month, value.day)))
    if isinstance(value, str):
        return _from_text(value.strip().strip("\"'").strip())
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if isinstance(value, float) and not math.isfinite(value):
        return None
    unit_ns = next(unit for bound, unit in _UNITS if abs(value) < bound)
    return _bounded(value * unit_ns if isinstance(value, int) else round(value * unit_ns))


def _from_text(text: str) -> int | None:
    if not 0 < len(text) < 40:
        return None
    if text.isdecimal() and text.isascii() and len(text) != len("20221026"):
        return instant_ns(int(text))
    try:
        return _bounded(_since_epoch(datetime.datetime.fromisoformat(text)))
    except (ValueError, OverflowError):
        pass
    try:
        return instant_ns(float(text))
    except ValueError:
        return None


def _since_epoch(moment: datetime.datetime) -> int:
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=datetime.UTC)
    elapsed = moment - _EPOCH
    return ((elapsed.days * 86_400 + elapsed.seconds) * 1_000_000 + elapsed.microseconds) * 1_000


def _bounded(at_ns: int) -> int | None:
    return at_ns if -LATEST_NS < at_ns < LATEST_NS else None
