"""The contract of a bridge: one outside world, read as observations."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import msgspec

from wakeful.facts.events import Draft, Observation, Undecodable
from wakeful.facts.evidence import Evidence, Outcome

Item = Observation | Undecodable | Draft | Evidence | Outcome


class Peek(msgspec.Struct, frozen=True):
    """What a source looks like before it is read: its bridge, its channels (``topic/name``), its length where known."""

    bridge: str
    channels: tuple[str, ...]
    items: int | None = None
    duration_s: float | None = None


class SourceError(Exception):
    """A source that cannot be read at all. The message says what is wrong, where, and what to do."""


class Bridge(Protocol):
    """Reads one kind of source. Items come in the order of the recording; positions count from 0 without gaps.

    What cannot be decoded is an Undecodable at its position: it is received and refused, and nothing else is lost.
    """

    name: str

    def claims(self, path: Path) -> bool:
        """Whether this bridge reads that path, by suffix or first bytes. Never raises."""

    def peek(self, path: Path) -> Peek:
        """Look at a source without reading it all. Raises SourceError where it cannot be read."""

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """The items with position > ``after``. Raises SourceError where it cannot be read at all."""

    def digest(self, path: Path) -> str:
        """A digest of the source's content: the same file, the same digest, under any name."""
