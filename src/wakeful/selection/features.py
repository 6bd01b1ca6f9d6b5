"""From an event to numbers: a vector of fixed length for a domain, the same on every machine and in every run."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from hashlib import blake2b
from itertools import islice
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from wakeful.facts.domain import DomainSpec, FieldSpec
from wakeful.facts.events import Draft, Event, Phase, Relation
from wakeful.facts.values import Field

Vector = npt.NDArray[np.float64]

SCHEME: Final = "2"
"""Counts up whenever the meaning of a column changes, so that ``Encoder.version`` does too."""

KIND_BUCKETS: Final = 4
ENTITY_BUCKETS: Final = 8
TASK_BUCKETS: Final = 4
ZONE_BUCKETS: Final = 8
CATEGORY_BUCKETS: Final = 16
NUMBER_BUCKETS: Final = 8

UNDECLARED_LIMIT: Final = 64
"""How many undeclared fields of one event are looked at."""
TOKEN_CHARS: Final = 96
"""A longer text is known by its beginning: it comes from the world and may be of any length."""
MEMO_LIMIT: Final = 8192

OUTSIDE_LOW: Final = -1.0
OUTSIDE_HIGH: Final = 2.0
"""What a declared number outside its range is clipped to."""
_BUCKET_LIMIT = 2.0
_IDENTITY = re.compile(r"[0-9a-fA-F]*\d\d[0-9a-fA-F]*")
_RELATIONS = tuple(Relation)
_PHASES = tuple(Phase)
_ABSENT: Final = object()


def squash(number: float) -> float:
    """An undeclared number in (-1, 1): tanh(sign(x) · ln(1 + |x|) / 4), so that 1, 10, 1000 and 10^6 stay apart.

    >>> [round(squash(x), 2) for x in (0.0, 1.0, 10.0, -1000.0, float("inf"))]
    [0.0, 0.17, 0.54, -0.94, 1.0]
    """
    return math.tanh(math.copysign(math.log1p(abs(number)), number) / 4.0)


def entity_class(entity: str) -> str:
    """An entity without its identity: numbers of two and more digits, and hex ids, become ``#``.

    A single digit stays: it names a part of the robot (joint 3, motor 1) rather than one of many things met.

    >>> entity_class("pallet-0042"), entity_class("joint_3")
    ('pallet-#', 'joint_3')
    """
    return _IDENTITY.sub("#", entity[:TOKEN_CHARS])


def bucket(token: str, buckets: int) -> int:
    """The bucket of a text, by blake2b: equal in every run, unlike Python's ``hash``."""
    return int.from_bytes(blake2b(token.encode("utf-8", "surrogatepass"), digest_size=8).digest(), "little") % buckets


Declared: TypeAlias = tuple[str, FieldSpec, int, dict[str, int], float]
"""Name, specification, first column, columns by category, and scale of a declared field."""


class Encoder:
    """Turns the events of one domain into vectors of length ``size``. Pure, apart from a bounded memo of buckets.

    Columns, in this order: for each declared field its values one by one, then ``other`` and ``missing`` (categorical), or its
    number scaled to [0, 1] (clipped to [-1, 2], so that a value outside its range is seen as such) and ``missing``; the
    domain's kinds, relation, criticality, safety, task, zone, phase of the condition; then hashed buckets for undeclared
    kinds, the class of the entity, tasks, zones, undeclared categories and undeclared numbers (see ``squash``). NaN and None are
    missing. Fields of the context are read under their own name where the event has none of that name.

    Args:
        spec: the domain; its fields and detectors fix the columns.
        treatments: what may be chosen; part of ``version``, since weights belong to both.
    """

    def __init__(self, spec: DomainSpec, treatments: tuple[str, ...]) -> None:
        self.columns: tuple[str, ...] = ()
        self.groups: dict[str, tuple[int, ...]] = {}
        self._names: list[str] = []
        self.fields: list[Declared] = []
        for name, field in spec.fields.items():
            self._declare(name, field)
        kinds = tuple(dict.fromkeys(detector.kind for detector in spec.detect))
        self.kinds = {kind: self._add("kind", f"kind={kind}") for kind in kinds}
        self._kind_at = self._block("kind", KIND_BUCKETS)
        self._entity_at = self._block("entity", ENTITY_BUCKETS)
        self.relations = {relation: self._add("relation", f"relation={relation}") for relation in _RELATIONS}
        self.criticality = self._add("criticality", "criticality")
        self._safety = self._add("safety", "safety")
        self._task = self._add("task", "task")
        self._task_at = self._block("task", TASK_BUCKETS)
        self._zone = self._add("zone", "zone")
        self._zone_at = self._block("zone", ZONE_BUCKETS)
        self._phases = {phase: self._add("condition", f"condition={phase}") for phase in _PHASES}
        self._category_at = self._block("other fields", CATEGORY_BUCKETS)
        self._number_at = self._block("other numbers", NUMBER_BUCKETS)
        self.columns = tuple(self._names)
        self.size = len(self.columns)
        self._declared = frozenset(spec.fields)
        self._memo: dict[tuple[int, int, str], int] = {}
        digest = blake2b("\x1f".join((SCHEME, *treatments, "\x1e", *self.columns)).encode(), digest_size=6)
        for name, field in spec.fields.items():
            digest.update(f"\x1f{name}{field.low!r}{field.high!r}".encode())
        self.version = digest.hexdigest()

    def encode(self, event: Event | Draft) -> Vector:
        """The event's features, shape (size,): finite whatever the event carries."""
        row = np.zeros(self.size)
        fields, context = event.fields, event.context
        for declared in self.fields:
            name = declared[0]
            value = fields.get(name, _ABSENT)
            if value is _ABSENT:
                value = context.fields.get(name)
            self.write_field(row, declared, value)
        self.write_others(row, fields)
        if context.fields:
            for name, value in islice(context.fields.items(), UNDECLARED_LIMIT):
                if name not in self._declared:
                    self._write_undeclared(row, f"context.{name}", value)
        row[self.kind(event.kind)] = 1.0
        row[self.entity(event.entity)] = 1.0
        row[self.relations[event.relation]] = 1.0
        row[self.criticality] = event.criticality / 3.0
        self.write_context(row, event)
        return row

    def write_context(self, row: Vector, event: Event | Draft) -> None:
        """Write what the event's context says beside its fields, and the phase of its condition."""
        context = event.context
        if context.safety:
            row[self._safety] = 1.0
        if context.task:
            row[self._task] = row[self._bucket(self._task_at, TASK_BUCKETS, entity_class(context.task))] = 1.0
        if context.zone:
            row[self._zone] = row[self._bucket(self._zone_at, ZONE_BUCKETS, context.zone)] = 1.0
        if event.condition is not None:
            row[self._phases[event.condition.phase]] = 1.0

    def kind(self, kind: str) -> int:
        """The column of an event's kind."""
        at = self.kinds.get(kind)
        return self._bucket(self._kind_at, KIND_BUCKETS, kind) if at is None else at

    def _declare(self, name: str, field: FieldSpec) -> None:
        if field.values:
            places = {value: self._add(name, f"{name}={value}") for value in dict.fromkeys(field.values)}
            start = self._add(name, f"{name} other")
            self.fields.append((name, field, start, places, 0.0))
        else:
            size = max(1, field.size)
            start = self._add(name, name if size == 1 else f"{name}[0]")
            for index in range(1, size):
                self._add(name, f"{name}[{index}]")
            span = field.high - field.low
            self.fields.append((name, field, start, {}, 1.0 / span if span and math.isfinite(span) else 0.0))
        self._add(name, f"{name} missing")

    def write_others(self, row: Vector, fields: Mapping[str, Field]) -> None:
        """Write the fields that the domain does not declare."""
        declared = self._declared
        if len(fields) > len(self.fields) or not declared.issuperset(fields):
            for name, value in islice(fields.items(), UNDECLARED_LIMIT):
                if name not in declared:
                    self._write_undeclared(row, name, value)

    def write_field(self, row: Vector, declared: Declared, value: object) -> None:
        """Write a declared field, whatever it holds; None: it is missing."""
        name, field, start, places, scale = declared
        if places:
            if value is None or value != value:  # NaN is no category
                row[start + 1] = 1.0
                return
            at = places.get(value if isinstance(value, str) else _token(value))
            if at is None:
                row[start] = 1.0
                self._write_category(row, name, value)
            else:
                row[at] = 1.0
            return
        size = max(1, field.size)
        if isinstance(value, tuple):
            numbers = [_number(item) for item in value[:size]] if size > 1 else [_mean(value)]
        elif isinstance(value, str):
            self._write_category(row, name, value)
            numbers = []
        else:
            numbers = [_number(value)]
        known = 0
        for index, number in enumerate(numbers):
            if number is not None:
                known += 1
                scaled = (number - field.low) * scale if scale else 0.0
                row[start + index] = min(max(scaled, OUTSIDE_LOW), OUTSIDE_HIGH)
        if known < size:
            row[start + size] = 1.0

    def _write_undeclared(self, row: Vector, name: str, value: Field) -> None:
        if value is None:
            return
        if isinstance(value, bool | str):
            self._write_category(row, name, value)
            return
        number = _mean(value) if isinstance(value, tuple) else _number(value)
        if number is not None:
            at = self._bucket(self._number_at, NUMBER_BUCKETS, name)
            row[at] = min(max(row[at] + squash(number), -_BUCKET_LIMIT), _BUCKET_LIMIT)

    def _write_category(self, row: Vector, name: str, value: object) -> None:
        token = value[:TOKEN_CHARS] if isinstance(value, str) else _token(value)
        row[self._bucket(self._category_at, CATEGORY_BUCKETS, f"{name}={token}")] = 1.0

    def entity(self, entity: str) -> int:
        """The column of an entity's class."""
        key = (self._entity_at, 0, entity)
        at = self._memo.get(key)
        if at is None:
            at = self._remember(key, self._entity_at + bucket(entity_class(entity), ENTITY_BUCKETS))
        return at

    def _bucket(self, start: int, buckets: int, token: str) -> int:
        key = (start, buckets, token)
        at = self._memo.get(key)
        return self._remember(key, start + bucket(token[:TOKEN_CHARS], buckets)) if at is None else at

    def _remember(self, key: tuple[int, int, str], at: int) -> int:
        if len(self._memo) < MEMO_LIMIT and len(key[2]) <= TOKEN_CHARS:
            self._memo[key] = at
        return at

    def _add(self, group: str, column: str) -> int:
        at = len(self._names)
        self._names.append(column)
        self.groups[group] = (*self.groups.get(group, ()), at)
        return at

    def _block(self, group: str, buckets: int) -> int:
        start = len(self._names)
        for index in range(buckets):
            self._add(group, f"{group} #{index}")
        return start


def _token(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value)[:TOKEN_CHARS]


def _number(value: object) -> float | None:
    """The value as a float, infinities kept; None where it is no number or NaN."""
    if not isinstance(value, bool | int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
    return None if math.isnan(number) else number


def _mean(values: tuple[float, ...]) -> float | None:
    numbers = [number for value in values if (number := _number(value)) is not None and math.isfinite(number)]
    return math.fsum(numbers) / len(numbers) if numbers else None
