"""A detector whose whole memory is one msgspec struct: it can be written out and taken up again."""

from __future__ import annotations

from typing import Generic, TypeVar

import msgspec

from wakeful.contracts.detector import Found, Offered, Shown

M = TypeVar("M", bound=msgspec.Struct)

Seen = Found | Shown | Offered


class Remembering(Generic[M]):
    """Base of detectors. All that a detector remembers stands in ``memory``; nothing else may change after construction."""

    def __init__(self, memory: M) -> None:
        self.memory = memory

    def state(self) -> bytes:
        """The memory as bytes."""
        return msgspec.msgpack.encode(self.memory)

    def restore(self, state: bytes) -> None:
        """Take up a memory that ``state`` gave out."""
        self.memory = msgspec.msgpack.decode(state, type=type(self.memory))
