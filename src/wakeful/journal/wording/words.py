"""Numbers, instants and outside text in words that a person reads."""

from __future__ import annotations

import unicodedata
from datetime import UTC, datetime

from wakeful.facts.time import NS_PER_S, to_s

#: Source instants after this one (the year 2000) are read as calendar time, earlier ones as seconds since the source's own zero.
_CALENDAR_NS = 946_684_800 * NS_PER_S
#: And before this one (the year 2200): beyond, a clock has gone wrong and its number is shown as it is.
_CALENDAR_END_NS = 7_258_118_400 * NS_PER_S


def plain(text: str, limit: int = 0) -> str:
    """Outside text on one line and without control characters, so that no log can steer the terminal.

    >>> plain("grip\\x1b[31m lost\\nnow")
    'grip[31m lost now'
    """
    spaced = " ".join(text.split())
    clean = "".join(letter for letter in spaced if unicodedata.category(letter) not in ("Cc", "Cf", "Cs", "Co"))
    return clean if not limit or len(clean) <= limit else clean[: limit - 1] + "…"


def count(number: int, one: str, many: str = "") -> str:
    """A number with its noun.

    >>> count(1, "event"), count(7409, "event")
    ('1 event', '7,409 events')
    """
    return f"{number:,} {one if number == 1 else many or one + 's'}"


def percent(fraction: float | None, digits: int = 1) -> str:
    """A fraction as a percentage; 100 % and 0 % only where it is exactly that.

    >>> percent(1.0), percent(0.99999), percent(0.5), percent(None)
    ('100 %', '99.9 %', '50.0 %', '–')
    """
    if fraction is None:
        return "–"
    if fraction in (0.0, 1.0):
        return f"{fraction * 100:.0f} %"
    edge = 10.0**-digits
    return f"{min(100 - edge, max(edge, fraction * 100)):.{digits}f} %"


def duration(seconds: float) -> str:
    """A span of time.

    >>> duration(0.0123), duration(2.44), duration(192), duration(7209), duration(-3)
    ('12 ms', '2.4 s', '3 min 12 s', '2 h 00 min', '-3.0 s')
    """
    size = abs(seconds)
    sign = "-" if seconds < 0 else ""
    if size == 0:
        return "0 s"
    if size < 0.9995:
        return f"{sign}{size * 1000:.0f} ms" if size >= 0.0095 else f"{sign}{size * 1000:.2g} ms"
    if size < 99.95:
        return f"{sign}{size:.1f} s"
    if size < 3599.5:
        minutes, rest = divmod(round(size), 60)
        return f"{sign}{minutes} min {rest:02d} s"
    hours, minutes = divmod(round(size / 60), 60)
    if hours < 100:
        return f"{sign}{hours} h {minutes:02d} min"
    return f"{sign}{hours / 24:,.1f} days"


def instant(at_ns: int) -> str:
    """A source's instant: calendar time in UTC where it is one, else seconds of the source's own clock.

    >>> instant(1_700_000_000_250_000_000), instant(12_300_000_000)
    ('2023-11-14 22:13:20.2', 't=12.3 s')
    """
    if _CALENDAR_NS <= at_ns < _CALENDAR_END_NS:
        moment = datetime.fromtimestamp(at_ns // NS_PER_S, UTC)
        return f"{moment:%Y-%m-%d %H:%M:%S}.{at_ns % NS_PER_S // 100_000_000}"
    return f"t={to_s(at_ns):.1f} s"
