"""Tables: a header and rows of cells, as observations of the topic ``row``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from typing import Final

import msgspec

from wakeful.bridges.content import excerpt
from wakeful.bridges.instants import instant_ns
from wakeful.bridges.plain import Raw, TooLarge, plain
from wakeful.contracts.bridge import Item, SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Value

TOPIC: Final = "row"
_TIME_NAMES: Final = ("timestamp", "datetime", "time", "date", "stamp", "at")
_LOOK_AHEAD_ROWS: Final = 50
_BLANK: Final = frozenset(("", "nan", "null", "none", "n/a", "#n/a"))

Cells = Sequence[Raw]


class Unreadable(msgspec.Struct, frozen=True):
    """A row that could not be split into cells, and why."""

    reason: str
    excerpt: str = ""


def observations(source: str, rows: Iterable[Cells | Unreadable], after: int = -1) -> Iterator[Item]:
    """Rows as observations; the first one is the header. Position 0 is the first row after it.

    Args:
        rows: cells may be numbers, bools, text, instants or None; text is interpreted (numbers, yes and no, blanks).
        after: the last position that is not wanted.

    Raises:
        SourceError: there is no header.
    """
    rest = iter(rows)
    names = _header(source, next(rest, None))
    ahead = list(islice(rest, _LOOK_AHEAD_ROWS))
    clock_column = _time_column(names, ahead)
    at_ns = -NS_PER_S
    for position, row in enumerate(chain(ahead, rest)):
        stamp = None
        if clock_column is not None and not isinstance(row, Unreadable) and clock_column < len(row):
            stamp = instant_ns(row[clock_column])
        at_ns = at_ns + NS_PER_S if stamp is None else stamp
        if position <= after:
            continue
        if isinstance(row, Unreadable):
            yield Undecodable(source=source, position=position, reason=row.reason, excerpt=row.excerpt)
            continue
        try:
            values = _values(names, row)
        except (TooLarge, ValueError) as failure:
            shown = excerpt(",".join(map(str, row[:8])))
            yield Undecodable(source=source, position=position, reason=str(failure), excerpt=shown)
            continue
        clock = "row" if stamp is None else "source"
        yield Observation(source=source, position=position, topic=TOPIC, at_ns=at_ns, values=values, clock=clock)


def cell(value: Raw) -> Value:
    """One cell as a plain value.

    >>> [cell(shown) for shown in ("12", " 1.5e3", "False", "", "nan", "stop")]
    [12, 1500.0, False, None, None, 'stop']
    """
    if not isinstance(value, str):
        return plain(value)
    shown = value.strip()
    word = shown.lower()
    if word in _BLANK:
        return None
    if word in ("true", "false"):
        return word == "true"
    if word[0] in "+-.0123456789i":
        for number in (int, float):
            try:
                return plain(number(shown))
            except ValueError:
                continue
    return plain(value)


def _header(source: str, row: Cells | Unreadable | None) -> tuple[str, ...]:
    if row is None or isinstance(row, Unreadable):
        why = "is empty" if row is None else f"has no header: {row.reason}"
        raise SourceError(f"{source} {why}; the first row must name the columns")
    named: Counter[str] = Counter()
    names = []
    for number, shown in enumerate(row, start=1):
        name = " ".join(str(plain(shown)).split()) if shown not in (None, "") else ""
        name = name or f"column_{number}"
        named[name] += 1
        names.append(name if named[name] == 1 else f"{name}.{named[name]}")
    if not names:
        raise SourceError(f"{source} has no columns; the first row must name them")
    return tuple(names)


def _time_column(names: tuple[str, ...], ahead: list[Cells | Unreadable]) -> int | None:
    """The first column that is called like an instant and whose first filled cell is one."""
    lower = [name.lower() for name in names]
    for wanted in _TIME_NAMES:
        for column, name in enumerate(lower):
            if name != wanted:
                continue
            cells = (row[column] for row in ahead if not isinstance(row, Unreadable) and column < len(row))
            if instant_ns(next((shown for shown in cells if shown not in (None, "")), None)) is not None:
                return column
    return None


def _values(names: tuple[str, ...], row: Cells) -> dict[str, Value]:
    if len(row) != len(names):
        raise ValueError(f"a row of {len(row)} cells under a header of {len(names)}")
    return {name: cell(shown) for name, shown in zip(names, row, strict=True)}
