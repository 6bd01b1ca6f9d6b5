"""One topic of a flight log: which of its rows are kept, and each row as plain values."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from wakeful.facts.values import Value

Column = NDArray[np.generic]
Times = NDArray[np.uint64]

MAX_ARRAY: Final = 32
_US_PER_S: Final = 1_000_000
#: A counter that changes in more than this share of the rows says nothing by changing.
_BUSY_SHARE: Final = 0.1
_INDEX: Final = re.compile(r"(.+)\[(\d+)\]$")
#: Topics with one of these words in their name are never thinned: a single row of them may be what matters.
_WHOLE: Final = frozenset(
    (
        *("ack", "alarm", "armed", "command", "detected", "detector", "event", "failsafe", "fault", "flags", "health", "log"),
        *("message", "mission", "mode", "safety", "state", "status", "switches", "warning"),
    )
)


def is_whole(topic: str) -> bool:
    """Whether a topic is named like a status, so that all of its rows are kept.

    >>> is_whole("vehicle_status"), is_whole("failsafe_flags"), is_whole("sensor_combined")
    (True, True, False)
    """
    return not _WHOLE.isdisjoint(re.split(r"[_\d.]+", topic))


def kept_rows(topic: str, times_us: Times, flags: Sequence[Column], max_hz: float) -> NDArray[np.intp]:
    """The rows to deliver, shape (kept,): all of a status topic or of a slow one, else at most ``max_hz`` a second.

    Args:
        times_us: the rows' times (n,), in microseconds.
        flags: the columns of bools and of 8-bit counters, each (n,): a row in which one of them changes is always kept.
        max_hz: 0 keeps everything.
    """
    rows = np.arange(len(times_us))
    if not max_hz or len(rows) < 2 or is_whole(topic):
        return rows
    spans = np.floor_divide(times_us, np.uint64(max(1, round(_US_PER_S / max_hz))))
    kept = np.ones(len(rows), dtype=bool)
    kept[1:] = spans[1:] != spans[:-1]
    for column in flags:
        changed = column[1:] != column[:-1]
        if changed.mean() <= _BUSY_SHARE:
            kept[1:] |= changed
    return rows[kept]


class Layout:
    """How a topic's columns become values: scalars, short arrays as lists, characters as text."""

    def __init__(self, columns: Mapping[str, Column], types: Mapping[str, str]) -> None:
        self.flags = [column for name, column in columns.items() if types.get(name) in ("bool", "uint8_t")]
        self._scalars: list[tuple[str, Column, bool]] = []
        arrays: dict[str, list[Column]] = {}
        for name, column in columns.items():
            if name == "timestamp" or name.rpartition(".")[2].startswith("_padding"):
                continue
            if indexed := _INDEX.match(name):
                arrays.setdefault(indexed[1], []).append(column)
            else:
                self._scalars.append((name, column, types.get(name) == "bool"))
        self._texts = {name: parts for name, parts in arrays.items() if types.get(f"{name}[0]") == "char"}
        self._lists = {
            name: (parts, types.get(f"{name}[0]") == "bool")
            for name, parts in arrays.items()
            if name not in self._texts and len(parts) <= MAX_ARRAY
        }

    def names(self) -> list[str]:
        """The names of the values."""
        return [*(name for name, _, _ in self._scalars), *self._lists, *self._texts]

    def values(self, row: int) -> dict[str, Value]:
        """One row. NaN and infinite numbers are None."""
        values: dict[str, Value] = {name: _plain(column[row], is_bool) for name, column, is_bool in self._scalars}
        for name, (parts, is_bool) in self._lists.items():
            values[name] = [_plain(part[row], is_bool) for part in parts]
        for name, parts in self._texts.items():
            values[name] = bytes(int(part[row]) & 0xFF for part in parts).split(b"\0", 1)[0].decode("utf-8", "replace")
        return values


def _plain(value: np.generic, is_bool: bool) -> Value:
    number = value.item()
    if is_bool:
        return bool(number)
    if isinstance(number, float):
        return number if np.isfinite(number) else None
    return int(number)
