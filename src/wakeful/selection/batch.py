"""Many events to numbers at once: what ``Encoder.encode`` gives for each, field by field over the batch instead of row by row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from wakeful.facts.events import Context, Draft, Event
from wakeful.selection.features import MEMO_LIMIT, OUTSIDE_HIGH, OUTSIDE_LOW, TOKEN_CHARS, Encoder, Vector

_NUMBERS: Final = frozenset((float, int, bool))
_LARGEST: Final = 1e300
_PLAIN: Final = Context()


class BatchEncoder:
    """The domain's encoder for batches of plain events: every declared field is there and of its kind, and no other.

    What is not plain (a field missing, undeclared, of another type, not finite, a vector; fields in the context) is encoded by
    ``Encoder`` itself. Each row is the same in any case, to the last bit.

    Args:
        encoder: of the domain.
    """

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder
        self._categories = [(name, places) for name, _, _, places, _ in encoder.fields if places]
        numeric = [(name, field, start, scale) for name, field, start, places, scale in encoder.fields if not places]
        self._any_vector = any(field.size > 1 for _, field, _, _ in numeric)
        self._numbers = [name for name, _, _, _ in numeric]
        self._columns = np.array([start for _, _, start, _ in numeric], dtype=np.intp)
        self._low = np.array([field.low for _, field, _, _ in numeric])
        self._scale = np.array([scale for _, _, _, scale in numeric])
        self._declared = len(encoder.fields)
        self._heads: dict[str, int] = {}

    def encode(self, events: Sequence[Event | Draft]) -> Vector:
        """The features of these events, shape (n, d)."""
        rows = np.zeros((len(events), self._encoder.size))
        if len(events) > 1 and not self._any_vector and self._write(rows, events):
            return rows
        plain = [place for place, event in enumerate(events) if self._is_plain(event)]
        together = np.zeros((len(plain), self._encoder.size))
        if len(plain) < 2 or not self._write(together, [events[place] for place in plain]):
            plain = []
        rows[:] = 0.0
        rows[plain] = together[: len(plain)]
        alone = set(range(len(events))).difference(plain)
        for place in alone:
            rows[place] = self._encoder.encode(events[place])
        return rows

    def _is_plain(self, event: Event | Draft) -> bool:
        fields = event.fields
        if self._any_vector or len(fields) != self._declared:
            return False
        for name, places in self._categories:
            value = fields.get(name)
            if not isinstance(value, str) or value not in places:
                return False
        return all(
            isinstance(value := fields.get(name), bool | int | float) and -_LARGEST < value < _LARGEST for name in self._numbers
        )

    def _write(self, rows: Vector, events: Sequence[Event | Draft]) -> bool:
        """Write the rows field by field; False, with nothing of use in them, where an event is not plain."""
        encoder = self._encoder
        every = [event.fields for event in events]
        declared = self._declared
        for fields in every:
            if len(fields) != declared:
                return False
        ones: list[list[int]] = []
        try:
            for name, places in self._categories:
                ones.append([places[fields[name]] for fields in every])  # type: ignore[index]  # nothing else is a key
            numbers = [[fields[name] for fields in every] for name in self._numbers]
        except (KeyError, TypeError):
            return False
        for column in numbers:
            if not _NUMBERS.issuperset(map(type, column)):
                return False
        kind, entity, relations = encoder.kind, self._entity, encoder.relations
        ones.append([kind(event.kind) for event in events])
        ones.append([entity(event.entity) for event in events])
        ones.append([relations[event.relation] for event in events])
        rows[np.arange(len(events)), np.array(ones, dtype=np.intp)] = 1.0
        if numbers:
            try:
                values = np.array(numbers, dtype=np.float64).T
            except OverflowError:
                return False
            if not (np.abs(values) < _LARGEST).all():
                return False
            scaled = np.where(self._scale != 0.0, (values - self._low) * self._scale, 0.0)
            rows[:, self._columns] = np.minimum(np.maximum(scaled, OUTSIDE_LOW), OUTSIDE_HIGH)
        rows[:, encoder.criticality] = [event.criticality / 3.0 for event in events]
        for place, event in enumerate(events):
            context = event.context
            if event.condition is not None or (context is not _PLAIN and context != _PLAIN):
                if context.fields:
                    rows[place] = encoder.encode(event)
                else:
                    encoder.write_context(rows[place], event)
        return True

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
