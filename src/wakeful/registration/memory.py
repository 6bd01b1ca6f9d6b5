"""What is remembered of each entity: its place, its fields, when something was last registered of it. Bounded.

New, unchanged, changed and moved are computed from it, never given.
"""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import blake2b
from typing import Final

import msgspec

from wakeful.facts.domain import FieldSpec
from wakeful.facts.events import Relation
from wakeful.facts.values import Field

SHARDS: Final = 32
ENTITIES_PER_SHARD: Final = 128
FIELDS: Final = 48
KINDS: Final = 16
RECENT: Final = 32

PLACE: Final = frozenset(("zone", "location", "place", "position", "node", "x", "y", "z"))
"""Fields that say where an entity is."""

SAME_SHARE: Final = 0.1
"""Two numbers within this share of the field's range (of their size where none is declared) are the same."""


class Known(msgspec.Struct):
    """What is known of one entity. ``observations``: its topics' counts at its last event."""

    zone: str = ""
    fields: dict[str, Field] = {}
    kinds: dict[str, int] = {}
    recent_ns: list[int] = []
    observations: dict[str, int] = {}


class EntityMemory:
    """At most SHARDS × ENTITIES_PER_SHARD entities; of a full shard the one longest unheard of is forgotten."""

    def __init__(self, fields: Mapping[str, FieldSpec]) -> None:
        self._specs = fields
        self._shards: list[dict[str, Known]] = [{} for _ in range(SHARDS)]
        self._changed: set[int] = set()

    def know(self, entity: str, zone: str, fields: Mapping[str, Field]) -> tuple[Relation, Known]:
        """Take up what was just registered of an entity.

        Returns:
            How it stands to what was remembered, and the memory of it, with its new place and fields.
        """
        number = _shard(entity)
        shard = self._shards[number]
        self._changed.add(number)
        known = shard.pop(entity, None)
        if known is None:
            relation = Relation.NEW
            if len(shard) >= ENTITIES_PER_SHARD:
                del shard[next(iter(shard))]
            known = Known()
        else:
            relation = self._relation(known, zone, fields)
        shard[entity] = known
        known.zone = zone or known.zone
        merged = {**known.fields, **fields}
        known.fields = dict(list(merged.items())[-FIELDS:]) if len(merged) > FIELDS else merged
        return relation, known

    def changed(self) -> dict[str, bytes]:
        """The shards that changed since the last call."""
        parts = {f"memory/{number:02d}": msgspec.msgpack.encode(self._shards[number]) for number in sorted(self._changed)}
        self._changed.clear()
        return parts

    def restore(self, parts: Mapping[str, bytes]) -> None:
        """Take up the shards among ``parts``; the others are empty."""
        self._changed.clear()
        for number in range(SHARDS):
            part = parts.get(f"memory/{number:02d}")
            self._shards[number] = {} if part is None else msgspec.msgpack.decode(part, type=dict[str, Known])

    def _relation(self, known: Known, zone: str, fields: Mapping[str, Field]) -> Relation:
        if zone and known.zone and zone != known.zone:
            return Relation.MOVED
        relation = Relation.UNCHANGED
        for name, value in fields.items():
            if name not in known.fields or not self._same(name, known.fields[name], value):
                if name in PLACE and name in known.fields:
                    return Relation.MOVED
                relation = Relation.CHANGED
        return relation

    def _same(self, name: str, before: Field, now: Field) -> bool:
        if isinstance(now, tuple) and isinstance(before, tuple):
            return len(before) == len(now) and all(self._near(name, was, is_) for was, is_ in zip(before, now, strict=True))
        if isinstance(before, bool) or isinstance(now, bool):
            return before is now
        if isinstance(before, int | float) and isinstance(now, int | float):
            return self._near(name, before, now)
        return before == now

    def _near(self, name: str, before: float, now: float) -> bool:
        spec = self._specs.get(name)
        size = max(abs(before), abs(now)) if spec is None or spec.values else spec.high - spec.low
        return abs(now - before) <= SAME_SHARE * size


def note(known: Known, kind: str, topic: str, observations: int, at_ns: int) -> None:
    """Note that an event of this kind was registered of the entity, at its topic's so-many-eth observation."""
    known.kinds.pop(kind, None)
    known.kinds[kind] = at_ns
    if len(known.kinds) > KINDS:
        del known.kinds[next(iter(known.kinds))]
    known.observations[topic] = observations
    if len(known.observations) > KINDS:
        del known.observations[next(iter(known.observations))]
    known.recent_ns = [*known.recent_ns[-(RECENT - 1) :], at_ns]


def _shard(entity: str) -> int:
    return blake2b(entity.encode(), digest_size=1).digest()[0] % SHARDS
