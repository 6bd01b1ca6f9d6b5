"""Audits: which events' outcomes count as evidence, drawn with a known probability that nothing about the event can move."""

from __future__ import annotations

from hashlib import blake2b
from typing import Final

_SPACE: Final = 2.0**64


def lot(seed: int, event: str) -> float:
    """The event's lot, uniform on [0, 1): the same in every run, independent of everything but seed and event id.

    An event id is a hash of where the event stood in its source, so nobody chooses it by how the event will end.

    >>> round(lot(0, "4f1e"), 6), lot(0, "4f1e") == lot(1, "4f1e")
    (0.437697, False)
    """
    digest = blake2b(event.encode("utf-8", "surrogatepass"), digest_size=8, key=str(seed).encode(), person=b"audit").digest()
    return int.from_bytes(digest, "little") / _SPACE


def drawn(seed: int, event: str, probability: float) -> bool:
    """Whether the event is drawn for an audit: true with exactly this probability over event ids.

    Args:
        seed: the mind's.
        event: the event's id.
        probability: in [0, 1]; what is drawn at one probability is drawn at every higher one.
    """
    return lot(seed, event) < probability
