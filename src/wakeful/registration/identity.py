"""Ids of evidence and outcomes: the same observation, read again, gives the same id, so that it counts once."""

from __future__ import annotations

from hashlib import blake2b

import msgspec

from wakeful.facts.events import Observation
from wakeful.facts.evidence import Evidence
from wakeful.facts.values import NOTHING, Raw


def outcome_id(digest: str, position: int, label: str, entity: str) -> str:
    """20 hex digits of (source digest, position, label, entity)."""
    return _id("outcome", digest, str(position), label, entity)


def evidence_of(digest: str, observation: Observation, topic: str, key: str, value: object, ordinal: int) -> Evidence:
    """Evidence at an observation; its id is of (source digest, position, ordinal, topic, key)."""
    return Evidence(
        id=_id("evidence", digest, str(observation.position), str(ordinal), topic, key),
        topic=topic,
        key=key,
        at_ns=observation.at_ns,
        value=_raw(value),
    )


def _raw(value: object) -> Raw:
    try:
        return Raw(msgspec.json.encode(value))
    except (TypeError, ValueError, OverflowError):
        # what JSON cannot say is evidence only of having been there
        return NOTHING


def _id(*parts: str) -> str:
    return blake2b("\x1f".join(parts).encode("utf-8", "replace"), digest_size=10).hexdigest()
