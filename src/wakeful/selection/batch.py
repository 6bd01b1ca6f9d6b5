"""Many events to numbers at once: what ``Encoder.encode`` gives for each, field by field over the batch instead of row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isnan
from typing import Final, TypeAlias

import numpy as np

from wakeful.facts.events import Context, Draft, Event
from wakeful.facts.values import Field
from wakeful.selection.features import MEMO_LIMIT, OUTSIDE_HIGH, OUTSIDE_LOW, TOKEN_CHARS, Declared, Encoder, Vector

Fields: TypeAlias = Mapping[str, Field]

_NUMBERS: Final = frozenset((float, int, bool))
_LARGEST: Final = 1e300
_PLAIN: Final = Context()


class BatchEncoder:
    """The domain's encoder for many events at once, field by field. Each row is what ``Encoder`` gives for the event, to the last
    bit: what is out of the ordinary (missing, of another type, not finite, undeclared) it writes itself, one by one.

    Args:
        encoder: of the domain.
    """

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder
        self._categories = [declared for declared in encoder.fields if declared[3]]
        self._numbers = [declared for declared in encoder.fields if not declared[3]]
        spans = [range(start, start + max(1, field.size)) for _, field, start, _, _ in self._numbers]
        self._columns = np.array([column for span in spans for column in span], dtype=np.intp)
        widths = [len(span) for span in spans]
        self._low = np.repeat([field.low for _, field, _, _, _ in self._numbers], widths)
        self._scale = np.repeat([scale for *_, scale in self._numbers], widths)
        self._heads: dict[str, int] = {}

    def encode(self, events: Sequence[Event | Draft]) -> Vector:
        """The features of these events, shape (n, d)."""
        encoder = self._encoder
        if len(events) < 2:  # one by itself is no batch
            return np.array([encoder.encode(event) for event in events]).reshape(len(events), encoder.size)
        rows = np.zeros((len(events), encoder.size))
        every = [event.fields for event in events]
        relations = [encoder.relations[event.relation] for event in events]
        odd: list[tuple[int, Declared, object]] = []
        ones = [relations, [encoder.kind(event.kind) for event in events], [self._entity(event.entity) for event in events]]
        ones += [self._places(declared, every, relations, odd) for declared in self._categories]
        rows[np.arange(len(events)), np.array(ones, dtype=np.intp)] = 1.0
        if self._numbers:
            columns = [column for declared in self._numbers for column in self._values(declared, every, odd)]
            scaled = np.where(self._scale != 0.0, (np.array(columns, dtype=np.float64).T - self._low) * self._scale, 0.0)
            rows[:, self._columns] = np.minimum(np.maximum(scaled, OUTSIDE_LOW), OUTSIDE_HIGH)
        rows[:, encoder.criticality] = [event.criticality / 3.0 for event in events]
        for place, declared, value in odd:
            _, field, start, places, _ = declared
            if not places:
                rows[place, start : start + max(1, field.size)] = 0.0
            encoder.write_field(rows[place], declared, value)
        unusual = {place for place, _, _ in odd}
        for place, event in enumerate(events):
            if len(every[place]) != len(encoder.fields) or place in unusual:
                encoder.write_others(rows[place], every[place])
            context = event.context
            if context.fields:
                rows[place] = encoder.encode(event)
            elif event.condition is not None or (context is not _PLAIN and context != _PLAIN):
                encoder.write_context(rows[place], event)
        return rows

    def _places(
        self, declared: Declared, every: Sequence[Fields], relations: list[int], odd: list[tuple[int, Declared, object]]
    ) -> list[int]:
        """The columns of a categorical field's values. Where one has none, it is told as odd, and that of the event's relation,
        which is written anyway, stands in."""
        name, _, _, places, _ = declared
        values = [fields.get(name) for fields in every]
        found = [places.get(value, -1) if value.__class__ is str else -1 for value in values]
        if -1 in found:
            for place, at in enumerate(found):
                if at < 0:
                    odd.append((place, declared, values[place]))
                    found[place] = relations[place]
        return found

    def _values(self, declared: Declared, every: Sequence[Fields], odd: list[tuple[int, Declared, object]]) -> list[list[float]]:
        """The columns of a numeric field's values, 0 where one is odd."""
        name, field, *_ = declared
        values = [fields.get(name) for fields in every]
        if field.size <= 1:
            if _NUMBERS.issuperset(map(type, values)):
                numbers: list[float] = values  # type: ignore[assignment]  # that is what they are
                if min(numbers) > -_LARGEST and max(numbers) < _LARGEST and not any(map(isnan, numbers)):
                    return [numbers]
            pairs = [_parts((value,), 1) for value in values]
        else:
            pairs = [_parts(value, field.size) for value in values]
        odd.extend((place, declared, values[place]) for place, parts in enumerate(pairs) if parts is None)
        nothing = (0.0,) * max(1, field.size)
        return [list(column) for column in zip(*(nothing if parts is None else parts for parts in pairs), strict=True)]

    def _entity(self, entity: str) -> int:
        """The column of the entity's class. Most names end in a number of their own: what stands before it is remembered."""
        head, dash, tail = entity.rpartition("-")
        if not (dash and len(tail) > 1 and len(entity) <= TOKEN_CHARS and tail.isascii() and tail.isdigit()):
            return self._encoder.entity(entity)
        at = self._heads.get(head)
        if at is None:
            at = self._encoder.entity(entity)
            if len(self._heads) < MEMO_LIMIT:
                self._heads[head] = at
        return at


def _is_plain(value: object) -> bool:
    """Whether it is a number within reason."""
    return value.__class__ in _NUMBERS and -_LARGEST < value < _LARGEST  # type: ignore[operator]  # it is a number


def _parts(value: object, size: int) -> tuple[float, ...] | None:
    """The first ``size`` numbers of a vector; None where it has not so many."""
    if not isinstance(value, tuple) or len(value) < size or not all(map(_is_plain, value[:size])):
        return None
    return value[:size]
