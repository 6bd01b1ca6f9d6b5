"""What a source says, as plain values: JSON-like, finite, and bounded."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping, Sequence
from typing import Final

from wakeful.facts.values import Value

MAX_TEXT_CHARS: Final = 4096
"""A longer text is cut."""
MAX_FIELD_CHARS: Final = 1_000_000
"""A message with a text beyond this is refused."""
MAX_DEPTH: Final = 32
_INT_BOUND: Final = 2**63

Raw = object
"""What a decoding library hands over."""


class TooLarge(ValueError):
    """A message holds more than an observation may: the message says what."""


def plain(value: Raw, depth: int = 0) -> Value:
    """``value`` as JSON can say it.

    NaN and infinite numbers become None, integers beyond 64 bits floats, instants ISO text. Raises TooLarge for a text beyond
    MAX_FIELD_CHARS or nesting beyond MAX_DEPTH.

    >>> plain({"speed": float("nan"), "state": "on", "trace": (1, float("inf"))})
    {'speed': None, 'state': 'on', 'trace': [1, None]}
    """
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return text(value)
    if isinstance(value, int):
        return int(value) if -_INT_BOUND <= value < _INT_BOUND else _as_float(value)
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if depth >= MAX_DEPTH:
        raise TooLarge(f"nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, Mapping):
        return {text(str(name)): plain(inner, depth + 1) for name, inner in value.items()}
    if isinstance(value, bytes | bytearray | memoryview):
        return f"{len(value)} bytes"
    if isinstance(value, Sequence):
        return [plain(inner, depth + 1) for inner in value]
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, datetime.timedelta):
        return value.total_seconds()
    return text(str(value))


def text(value: str) -> str:
    """The text, cut at MAX_TEXT_CHARS, and such that it can always be encoded. Raises TooLarge beyond MAX_FIELD_CHARS."""
    if len(value) > MAX_TEXT_CHARS:
        if len(value) > MAX_FIELD_CHARS:
            raise TooLarge(f"a text of {len(value):,} characters; the limit is {MAX_FIELD_CHARS:,}")
        value = value[:MAX_TEXT_CHARS]
    return value if value.isascii() else value.encode("utf-8", "replace").decode()


def _as_float(value: int) -> float | None:
    try:
        return float(value)
    except OverflowError:
        return None
