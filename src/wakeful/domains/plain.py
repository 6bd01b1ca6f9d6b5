"""Plain values out of observations whose content nobody vouches for: absent, None, NaN, of the wrong type, enormous."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from wakeful.facts.values import Value

Values = Mapping[str, Value]

LARGEST = 1e12
"""A number beyond this is taken for garbage: no field of a robot's messages means it."""


def number(values: Values, key: str) -> float | None:
    """The finite number under ``key``, a bool as 0 or 1; None for anything else.

    >>> number({"v": 1.5}, "v"), number({"v": float("nan")}, "v"), number({"v": "1.5"}, "v"), number({}, "v")
    (1.5, None, None, None)
    """
    return finite(values.get(key))


def finite(value: object) -> float | None:
    """``value`` as a finite number of believable size, or None."""
    if not isinstance(value, bool | int | float):
        return None
    try:
        found = float(value)
    except OverflowError:
        return None
    return found if math.isfinite(found) and abs(found) <= LARGEST else None


def whole(values: Values, key: str) -> int | None:
    """The whole number under ``key``, exact up to 64 bits (bit masks need every bit); None for anything else."""
    value = values.get(key)
    if isinstance(value, int):
        return int(value) if 0 <= value < 2**63 else (int(value) if -(2**63) <= value < 0 else None)
    found = finite(value)
    return round(found) if found is not None and found == round(found) else None


def flag(values: Values, key: str) -> bool | None:
    """Whether the value under ``key`` is on (true, or a number other than 0); None where it is no flag."""
    found = number(values, key)
    return None if found is None else found != 0.0


def text(values: Values, key: str, most: int = 300) -> str:
    """The text under ``key``, without control characters and cut to ``most`` characters; empty for anything else."""
    value = values.get(key)
    if not isinstance(value, str):
        return ""
    value = value[: 4 * most]
    if value.isprintable():
        return value.strip()[:most]
    return "".join(letter if letter.isprintable() else " " for letter in value).strip()[:most]


def series(values: Values, key: str) -> tuple[float | None, ...]:
    """The numbers under ``key``: a list, or the fields ``key[0]``, ``key[1]``, … None stands for what is no number.

    >>> series({"vibe[0]": 1, "vibe[1]": 2.5}, "vibe"), series({"vibe": [1, None]}, "vibe"), series({}, "vibe")
    ((1.0, 2.5), (1.0, None), ())
    """
    value = values.get(key)
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return tuple(finite(one) for one in value[:1000])
    found: list[float | None] = []
    while (name := f"{key}[{len(found)}]") in values and len(found) < 1000:
        found.append(number(values, name))
    return tuple(found)


def within(value: float, low: float, high: float) -> float:
    """``value`` brought into [low, high], rounded to 4 digits: event fields stay small and comparable."""
    return round(min(high, max(low, value)), 4)
