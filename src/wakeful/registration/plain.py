"""Plain numbers, words and instants out of values that nobody vouches for: absent, None, NaN, of the wrong type, enormous."""

from __future__ import annotations

import math
from typing import Final

from wakeful.facts.values import Field

LARGEST: Final = 1e150
"""A number beyond this is none: its square would be infinite."""
LONGEST: Final = 200
"""Characters of a text that are kept."""
ITEMS: Final = 64
"""Numbers of a vector that are kept."""
LARGEST_INT: Final = 2**62
"""Instants and whole numbers are kept within this, so that they can be written down."""

STEP_BACK_NS: Final = 60_000_000_000
"""A clock that runs back by more than this was set anew; by less, its messages came out of order."""

_TRUE = frozenset(("true", "yes", "on"))
_FALSE = frozenset(("false", "no", "off"))

Scalar = bool | int | float | str


def number(value: object) -> float | None:
    """The finite number that ``value`` is, or None. A bool or a text is no number.

    >>> number(2), number(float("nan")), number(True), number("2")
    (2.0, None, None, None)
    """
    if value.__class__ is float or (isinstance(value, int | float) and not isinstance(value, bool)):
        return float(value) if -LARGEST < value < LARGEST else None
    return None


def scalar(value: object) -> Scalar | None:
    """``value`` as something that can be compared and written down; None for what is empty, a list or a mapping.

    Words that mean yes or no are taken as such, blanks as nothing.

    >>> scalar("True"), scalar("  "), scalar(float("inf")), scalar([1]), scalar("HOLD")
    (True, None, None, None, 'HOLD')
    """
    if isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value if -LARGEST_INT < value < LARGEST_INT else None
    if isinstance(value, float):
        return number(value)
    if isinstance(value, str):
        text = clean(value).strip()
        word = text.lower()
        return True if word in _TRUE else False if word in _FALSE else text or None
    return None


def clean(text: str, longest: int = LONGEST) -> str:
    """The text's beginning, without lone surrogates: it can always be encoded."""
    text = text[:longest]
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def field(value: object) -> Field:
    """``value`` as an event's field: finite, of bounded size; None where it says nothing."""
    if isinstance(value, str):
        return clean(value)
    if isinstance(value, list | tuple):
        numbers = tuple(number(item) for item in value[:ITEMS])
        return tuple(item for item in numbers if item is not None) if None not in numbers else clean(str(value))
    return scalar(value)


def instant(at_ns: int) -> int:
    """The instant, kept within what can be written down."""
    return min(max(at_ns, -LARGEST_INT), LARGEST_INT)


def elapsed_s(now_ns: int, then_ns: int | None) -> float:
    """Seconds from ``then_ns`` to ``now_ns``; infinite where there was no then, or the clock was set back since.

    >>> elapsed_s(3_000_000_000, 1_000_000_000), elapsed_s(5, None), elapsed_s(0, 10), elapsed_s(0, 10**15)
    (2.0, inf, 0.0, inf)
    """
    if then_ns is None:
        return math.inf
    gone = now_ns - then_ns
    if gone < 0:
        return 0.0 if gone > -STEP_BACK_NS else math.inf
    return gone / 1e9
